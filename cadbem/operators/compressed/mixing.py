"""Mixed kernels: on each patch, one linear combination of the single and the double layer.

On a patch with mixing matrices F and U (components, unknowns), an unknown q acts by the kernel
S F + D U.  Arrays ``mixing`` (patches, 2, components, unknowns) hold F and U.
"""

from __future__ import annotations

from cadbem.compiled import compiled


@compiled(fastmath=True, error_model="numpy")
def mix(table, single, double, mixing, patch, first, out):
    """Mixed kernel out (rows, unknowns, M) from a ``table`` (entries, M) of one target.

    The M sources are those of panels, from ``first``[e] on on the patch ``patch``[e].
    """
    rows, unknowns = out.shape[0], out.shape[1]
    out[:] = 0.0
    for e in range(len(patch)):
        low, high = first[e], first[e + 1]
        for i in range(rows):
            for k in range(unknowns):
                values = out[i, k, low:high]
                for j in range(single.shape[1]):
                    f, u = mixing[patch[e], 0, j, k], mixing[patch[e], 1, j, k]
                    if f != 0.0:
                        entry = table[single[i, j], low:high]
                        for m in range(high - low):
                            values[m] += f * entry[m]
                    if u != 0.0:
                        entry = table[double[i, j], low:high]
                        for m in range(high - low):
                            values[m] += u * entry[m]


@compiled(fastmath=True, error_model="numpy")
def mix_one(table, single, double, factors, out):
    """Column out (rows, T) of one source's unknown, from a ``table`` (entries, T).

    ``factors`` (2, components) are the unknown's in F and U.
    """
    for i in range(out.shape[0]):
        for t in range(out.shape[1]):
            total = 0.0
            for j in range(single.shape[1]):
                total += factors[0, j] * table[single[i, j], t]
                total += factors[1, j] * table[double[i, j], t]
            out[i, t] = total


@compiled(fastmath=True, error_model="numpy")
def integrate(values, first, basis, basis_first, functions, function_first, out):
    """Integrals out (·, F) of tables ``values`` (·, M) against the functions of panels.

    Panel e has the nodes from ``first``[e] on, the weighted functions (functions, nodes) from
    ``basis_first``[e] on, and its functions are columns ``functions``[function_first[e]:] of out.
    """
    out[:] = 0.0
    for e in range(len(first) - 1):
        low, count = first[e], first[e + 1] - first[e]
        places = functions[function_first[e] :]
        width = function_first[e + 1] - function_first[e]
        table = basis[basis_first[e] : basis_first[e + 1]].reshape((width, count))
        for r in range(values.shape[0]):
            for f in range(width):
                total, here, weights = 0.0, values[r, low : low + count], table[f]
                for m in range(count):
                    total += here[m] * weights[m]
                out[r, places[f]] += total
