"""What is warned about or refused in units of length and in sizes.

The box of these tests is that of `named_box.py`.
"""

import warnings
from pathlib import Path

import numpy as np
import pytest
from named_box import SIZES, named_box, with_lines

from cadbem import CadWarning
from cadbem.boundary import Boundary
from cadbem.cad import inspect_cad, read_cad
from cadbem.errors import CadError

GEOMETRIES = Path(__file__).resolve().parents[1] / "geometries"
MILLIMETRE = "( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) );"


def warned(path: Path) -> tuple[Boundary, list[str]]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        boundary = read_cad(path)
    assert all(issubclass(warning.category, CadWarning) for warning in caught)
    return boundary, [str(warning.message) for warning in caught]


def test_a_step_file_without_a_unit_is_taken_for_millimetres(folder: Path):
    path = named_box(folder / "box.step")
    text = path.read_text()
    assert MILLIMETRE in text
    path.write_text(text.replace(MILLIMETRE, "( NAMED_UNIT(*) TIME_UNIT() );"))
    boundary, (line,) = warned(path)
    assert "box.step: no unit of length is given, mm is assumed" in line
    assert boundary.unit == "mm"
    assert boundary.volume() == pytest.approx(6, rel=1e-12)
    assert line in inspect_cad(path).remarks


def iges_unit(path: Path, words: str) -> Path:
    lines = path.read_text().splitlines()
    text = "".join(line[:72].rstrip() for line in lines if line[72:73] == "G")
    assert ",2,2HMM," in text
    text = text.replace(",2,2HMM,", f",{words},")
    rows = [text[i : i + 72] for i in range(0, len(text), 72)]
    header = [f"{row:72}G{n:7}" for n, row in enumerate(rows, start=1)]
    start = [line for line in lines if line[72:73] == "S"]
    rest = [line for line in lines if line[72:73] in ("D", "P")]
    last = f"{lines[-1][:8]}G{len(header):7}{lines[-1][16:]}"
    path.write_text("\n".join([*start, *header, *rest, last]) + "\n")
    return path


def test_an_iges_file_without_a_unit_is_taken_for_inches(folder: Path):
    """IGES 5.3, 2.2.4.3.14: the unit flag's default is 1, inches."""
    boundary, (line,) = warned(iges_unit(named_box(folder / "box.igs"), ","))
    assert "box.igs: no unit of length is given, inch is assumed" in line
    assert boundary.unit == "inch"
    assert np.allclose(boundary.bounds(), [[0, 0, 0], SIZES], atol=1e-9)


def test_an_iges_unit_that_contradicts_its_name_is_warned_about(folder: Path):
    boundary, lines = warned(iges_unit(named_box(folder / "box.igs"), "6,2HMM"))
    assert "m by its number but mm by its name" in lines[0]
    assert boundary.unit == "m"


def test_parts_in_different_units_are_refused(folder: Path):
    """A second part with faces, in metres."""
    path = with_lines(
        named_box(folder / "box.step"),
        "#9001=( GEOMETRIC_REPRESENTATION_CONTEXT(3) GLOBAL_UNIT_ASSIGNED_CONTEXT((#9002))"
        " REPRESENTATION_CONTEXT('','') );\n"
        "#9002=( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT($,.METRE.) );\n"
        "#9003=ADVANCED_BREP_SHAPE_REPRESENTATION('',({solid}),#9001);",
    )
    with pytest.raises(CadError, match="box.step.*lengths are in m and in mm.*one unit"):
        read_cad(path)


def test_an_inch_of_another_length_is_refused(folder: Path):
    path = named_box(folder / "box.step")
    inch = """( CONVERSION_BASED_UNIT('INCH',#9001) LENGTH_UNIT() NAMED_UNIT(#9003) );
#9001 = LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(24.5),#9002);
#9002 = ( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) );
#9003 = DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);"""
    path.write_text(path.read_text().replace(MILLIMETRE, inch))
    with pytest.raises(CadError, match="box.step.*inch is said to be 24.5 mm"):
        read_cad(path)


@pytest.mark.parametrize(
    ("prefix", "scale", "words"),
    [
        ("$", 40 / 3, "box.step: this channel is 40 m wide; is its unit really m?"),
        (".MILLI.", 400.0, "this channel is 1200 mm (1.2 m) wide; is its unit really mm?"),
        (".MILLI.", 300.0, ""),
        (".MICRO.", 1.0, ""),
    ],
)
def test_an_unusual_size_is_warned_about(folder: Path, prefix: str, scale: float, words: str):
    """The longest side is 3 × scale; more than 1 m is no microchannel."""
    path = named_box(folder / "box.step", scale)
    path.write_text(path.read_text().replace("SI_UNIT(.MILLI.", f"SI_UNIT({prefix}"))
    _, lines = warned(path)
    assert len(lines) == bool(words)
    assert words in "".join(lines)


@pytest.mark.parametrize("name", ["square_channel.step", "constriction.step", "round_pipe.igs"])
def test_our_geometries_give_no_warnings(name: str):
    assert warned(GEOMETRIES / name)[1] == []
    assert inspect_cad(GEOMETRIES / name).remarks == ()
