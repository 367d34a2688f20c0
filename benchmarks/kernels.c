/* Peers of the compiled kernels: the same sums and tables in C, and Stokes flow's table times the
   functions of panels by hand.  Arrays of vectors hold one component after the other. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#ifdef __AVX512F__
#include <immintrin.h>
#endif

#define R const double *restrict
#define DIFFERENCE_3                                                                               \
    const double rx = px[k] - x, ry = py[k] - y, rz = pz[k] - z;                                   \
    const double square = rx * rx + ry * ry + rz * rz, i = 1.0 / sqrt(square);
#define DIFFERENCE_2                                                                               \
    const double rx = px[k] - x, ry = py[k] - y, i = 1.0 / (rx * rx + ry * ry);
#define PLACES_3                                                                                   \
    R px = p, *restrict py = p + n, *restrict pz = p + 2 * n;                                      \
    R ax = a, *restrict ay = a + n, *restrict az = a + 2 * n;
#define PLACES_2 R px = p, *restrict py = p + n; R ax = a, *restrict ay = a + n;

void single_3d(long m, R t, long n, R p, R a, R u, double *restrict out)
{
    PLACES_3
    for (long j = 0; j < m; j++) {
        const double x = t[j], y = t[m + j], z = t[2 * m + j];
        double sx = 0, sy = 0, sz = 0;
        for (long k = 0; k < n; k++) {
            DIFFERENCE_3
            const double along = (rx * ax[k] + ry * ay[k] + rz * az[k]) * i * i;
            sx += i * (ax[k] + rx * along);
            sy += i * (ay[k] + ry * along);
            sz += i * (az[k] + rz * along);
        }
        out[j] += sx, out[m + j] += sy, out[2 * m + j] += sz;
    }
}

void double_3d(long m, R t, long n, R p, R a, R u, double *restrict out)
{
    PLACES_3
    R ux = u, *restrict uy = u + n, *restrict uz = u + 2 * n;
    for (long j = 0; j < m; j++) {
        const double x = t[j], y = t[m + j], z = t[2 * m + j];
        double sx = 0, sy = 0, sz = 0;
        for (long k = 0; k < n; k++) {
            DIFFERENCE_3
            const double flux = rx * ax[k] + ry * ay[k] + rz * az[k], i2 = i * i;
            const double f = -6.0 * (rx * ux[k] + ry * uy[k] + rz * uz[k]) * flux * i2 * i2 * i;
            sx += f * rx, sy += f * ry, sz += f * rz;
        }
        out[j] += sx, out[m + j] += sy, out[2 * m + j] += sz;
    }
}

void single_2d(long m, R t, long n, R p, R a, R u, double *restrict out)
{
    PLACES_2
    for (long j = 0; j < m; j++) {
        const double x = t[j], y = t[m + j];
        double sx = 0, sy = 0;
        for (long k = 0; k < n; k++) {
            DIFFERENCE_2
            const double l = 0.5 * log(i), along = (rx * ax[k] + ry * ay[k]) * i;
            sx += l * ax[k] + rx * along, sy += l * ay[k] + ry * along;
        }
        out[j] += sx, out[m + j] += sy;
    }
}

void double_2d(long m, R t, long n, R p, R a, R u, double *restrict out)
{
    PLACES_2
    R ux = u, *restrict uy = u + n;
    for (long j = 0; j < m; j++) {
        const double x = t[j], y = t[m + j];
        double sx = 0, sy = 0;
        for (long k = 0; k < n; k++) {
            DIFFERENCE_2
            const double f =
                -4.0 * (rx * ux[k] + ry * uy[k]) * (rx * ax[k] + ry * ay[k]) * i * i;
            sx += f * rx, sy += f * ry;
        }
        out[j] += sx, out[m + j] += sy;
    }
}

/* Tables (entries, m n): one row of n pairs a target. */
#define ROW(e) double *restrict o##e = out + (e) * m * n + j * n

void stokes_3d(long m, R t, long n, R p, R a, double *restrict out)
{
    PLACES_3
    for (long j = 0; j < m; j++) {
        const double x = t[j], y = t[m + j], z = t[2 * m + j];
        ROW(0); ROW(1); ROW(2); ROW(3); ROW(4); ROW(5);
        ROW(6); ROW(7); ROW(8); ROW(9); ROW(10); ROW(11);
#pragma GCC ivdep
        for (long k = 0; k < n; k++) {
            DIFFERENCE_3
            const double c = i * i * i;
            const double s = -6.0 * (rx * ax[k] + ry * ay[k] + rz * az[k]) * c * i * i;
            o0[k] = i + rx * rx * c, o1[k] = rx * ry * c, o2[k] = rx * rz * c;
            o3[k] = i + ry * ry * c, o4[k] = ry * rz * c, o5[k] = i + rz * rz * c;
            o6[k] = rx * rx * s, o7[k] = rx * ry * s, o8[k] = rx * rz * s;
            o9[k] = ry * ry * s, o10[k] = ry * rz * s, o11[k] = rz * rz * s;
        }
    }
}

void pressure_3d(long m, R t, long n, R p, R a, double *restrict out)
{
    PLACES_3
    for (long j = 0; j < m; j++) {
        const double x = t[j], y = t[m + j], z = t[2 * m + j];
        ROW(0); ROW(1); ROW(2); ROW(3); ROW(4); ROW(5);
#pragma GCC ivdep
        for (long k = 0; k < n; k++) {
            DIFFERENCE_3
            const double c = i * i * i;
            const double s = 12.0 * (rx * ax[k] + ry * ay[k] + rz * az[k]) * c * i * i;
            o0[k] = 2 * rx * c, o1[k] = 2 * ry * c, o2[k] = 2 * rz * c;
            o3[k] = rx * s - 4 * ax[k] * c;
            o4[k] = ry * s - 4 * ay[k] * c;
            o5[k] = rz * s - 4 * az[k] * c;
        }
    }
}

void laplace_3d(long m, R t, long n, R p, R a, double *restrict out)
{
    PLACES_3
    for (long j = 0; j < m; j++) {
        const double x = t[j], y = t[m + j], z = t[2 * m + j];
        ROW(0); ROW(1);
#pragma GCC ivdep
        for (long k = 0; k < n; k++) {
            DIFFERENCE_3
            o0[k] = i;
            o1[k] = -(rx * ax[k] + ry * ay[k] + rz * az[k]) * i * i * i;
        }
    }
}

void stokes_2d(long m, R t, long n, R p, R a, double *restrict out)
{
    PLACES_2
    for (long j = 0; j < m; j++) {
        const double x = t[j], y = t[m + j];
        ROW(0); ROW(1); ROW(2); ROW(3); ROW(4); ROW(5);
#pragma GCC ivdep
        for (long k = 0; k < n; k++) {
            DIFFERENCE_2
            const double l = 0.5 * log(i), s = -4.0 * (rx * ax[k] + ry * ay[k]) * i;
            const double xx = rx * rx * i, xy = rx * ry * i, yy = ry * ry * i;
            o0[k] = l + xx, o1[k] = xy, o2[k] = l + yy;
            o3[k] = s * xx, o4[k] = s * xy, o5[k] = s * yy;
        }
    }
}

void pressure_2d(long m, R t, long n, R p, R a, double *restrict out)
{
    PLACES_2
    for (long j = 0; j < m; j++) {
        const double x = t[j], y = t[m + j];
        ROW(0); ROW(1); ROW(2); ROW(3);
#pragma GCC ivdep
        for (long k = 0; k < n; k++) {
            DIFFERENCE_2
            const double s = 8.0 * (rx * ax[k] + ry * ay[k]) * i;
            o0[k] = 2 * rx * i, o1[k] = 2 * ry * i;
            o2[k] = (s * rx - 4 * ax[k]) * i, o3[k] = (s * ry - 4 * ay[k]) * i;
        }
    }
}

void laplace_2d(long m, R t, long n, R p, R a, double *restrict out)
{
    PLACES_2
    for (long j = 0; j < m; j++) {
        const double x = t[j], y = t[m + j];
        ROW(0); ROW(1);
#pragma GCC ivdep
        for (long k = 0; k < n; k++) {
            DIFFERENCE_2
            o0[k] = 0.5 * log(i);
            o1[k] = -(rx * ax[k] + ry * ay[k]) * i;
        }
    }
}

/* By hand: what panels e of n nodes each, p and a (panels, 3, n), do to m targets (a multiple of
   8) by way of 9 weighted functions (panels, n, 9): out (panels, m / 8, 12, 9, 8). */
int panels_by_hand(long m, R t, long panels, long n, R p, R a, R basis, double *restrict out)
{
#ifdef __AVX512F__
    __m512d *table = aligned_alloc(64, 12 * n * sizeof(__m512d));
    const __m512d half = _mm512_set1_pd(0.5), three = _mm512_set1_pd(1.5);
    for (long e = 0; e < panels; e++, p += 3 * n, a += 3 * n, basis += 9 * n)
        for (long j = 0; j < m; j += 8) {
            const __m512d x = _mm512_loadu_pd(t + j), y = _mm512_loadu_pd(t + m + j);
            const __m512d z = _mm512_loadu_pd(t + 2 * m + j);
            for (long k = 0; k < n; k++) {
                const __m512d rx = _mm512_sub_pd(_mm512_set1_pd(p[k]), x);
                const __m512d ry = _mm512_sub_pd(_mm512_set1_pd(p[n + k]), y);
                const __m512d rz = _mm512_sub_pd(_mm512_set1_pd(p[2 * n + k]), z);
                const __m512d xx = rx * rx, yy = ry * ry, zz = rz * rz, square = xx + yy + zz;
                const __m512d small = half * square;
                __m512d i = _mm512_rsqrt14_pd(square);
                i = i * (three - small * i * i);
                i = i * (three - small * i * i);
                const __m512d across = rx * _mm512_set1_pd(a[k]) + ry * _mm512_set1_pd(a[n + k])
                                       + rz * _mm512_set1_pd(a[2 * n + k]);
                const __m512d c = i * i * i, s = _mm512_set1_pd(-6.0) * across * c * i * i;
                const __m512d xy = rx * ry, xz = rx * rz, yz = ry * rz;
                __m512d *o = table + 12 * k;
                o[0] = i + xx * c, o[1] = xy * c, o[2] = xz * c;
                o[3] = i + yy * c, o[4] = yz * c, o[5] = i + zz * c;
                o[6] = xx * s, o[7] = xy * s, o[8] = xz * s;
                o[9] = yy * s, o[10] = yz * s, o[11] = zz * s;
            }
            for (long entry = 0; entry < 12; entry++, out += 72) {
                __m512d s[9];
                for (int f = 0; f < 9; f++)
                    s[f] = _mm512_setzero_pd();
                for (long k = 0; k < n; k++)
                    for (int f = 0; f < 9; f++)
                        s[f] += table[12 * k + entry] * _mm512_set1_pd(basis[9 * k + f]);
                for (int f = 0; f < 9; f++)
                    _mm512_storeu_pd(out + 8 * f, s[f]);
            }
        }
    free(table);
    return 1;
#else
    return 0;
#endif
}
