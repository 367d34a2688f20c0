"""``cadbem verify``: each check against its own reference, and what happens when one fails."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from cadbem import verification
from cadbem.cli import main
from cadbem.errors import CadbemError
from cadbem.verification import (
    Check,
    all_checks,
    confined,
    drops,
    heat,
    integrals,
    plane,
    spheres,
    true_series,
)

REFERENCE = json.loads((Path(__file__).parent / "data" / "reference.json").read_text())
FAST = all_checks()
LONG = [check for check in all_checks(full=True) if check.long]
HALF = Check("nowhere", "a half", lambda: 0.5, 0.5, 0.0, "arithmetic")


def name(check: Check) -> str:
    return f"{check.place}: {check.what}"


def test_names_tell_checks_apart():
    assert len({name(check) for check in (*FAST, *LONG)}) == len(FAST) + len(LONG)


@pytest.mark.parametrize("check", FAST, ids=name)
def test_fast_check(check):
    """Closed forms, series, and spectral computations: ``check.source`` says which."""
    result = check.run()
    assert result.passed, f"{result.computed} instead of {check.reference} ({check.source})"


@pytest.mark.long
@pytest.mark.parametrize("check", LONG, ids=name)
def test_long_check(check):
    test_fast_check(check)


def test_references_are_those_computed_elsewhere():
    """Numbers that the package carries, against the file that they were taken from."""
    for table, place in ((integrals.TABLE_1, "table_2_1"), (integrals.TABLE_2, "table_2_2")):
        exact = [float(value) for value in REFERENCE[place]["I"]]
        assert [row[0] for row in table.values()] == exact
    assert [row[0] for row in integrals.TABLE_3.values()] == [
        float(value) for value in REFERENCE["table_2_3"]["I"]
    ]
    conduction = REFERENCE["benchmark_1_and_2"]
    assert float(conduction["benchmark_I"]["C1"]) == heat.RING_SLOPE
    assert float(conduction["benchmark_II"]["C1"]) == heat.SHELL_HEAT
    assert spheres.WALL[2.0][0] == REFERENCE["sphere_near_wall"]["2.000000000000"]["Ft"]
    plates = REFERENCE["drop_3d_between_plates_Ca0.2_lambda1_RW0.8"]
    known = dict(zip(plates["tau"], plates["D"], strict=True))
    assert {tau: known[tau] for tau in confined.EARLY} == confined.EARLY
    series = REFERENCE["drop_2d_shear"]["Cat0.1_l1"]
    known = dict(zip(series["tau"], series["D"], strict=True))
    assert {tau: known[tau] for tau in plane.SERIES} == plane.SERIES
    assert_same(true_series.PLANE_SHEAR, series)
    assert_same(true_series.PLATES, plates)
    assert_same(true_series.SHEAR, REFERENCE["drop_3d_shear_Ca0.2_lambda1"])
    known = REFERENCE["drop_3d_extension_lambda10"]
    assert (known["Ca"], known["D"]) == true_series.EXTENSION
    assert set(drops.PRINTED) == {(0.35, 1.0), (0.4, 1.0), (0.35, 0.1), (0.4, 0.1)}


def assert_same(found: true_series.TrueSeries, known: dict) -> None:
    """To ten digits."""
    assert found.times == pytest.approx(known["tau"])
    assert found.deformation == pytest.approx(known["D"], abs=1e-10)
    assert found.steady == known.get("D_steady", known["D"][-1])


def verify(monkeypatch: pytest.MonkeyPatch, *checks: Check) -> int:
    """Exit code of the command with these checks alone."""
    monkeypatch.setattr(verification, "all_checks", lambda full: checks)
    return main(["verify"])


def test_table_of_a_success(monkeypatch, capsys):
    assert verify(monkeypatch, replace(HALF, printed=0.51)) == 0
    head, row, last = capsys.readouterr().out.splitlines()
    assert head.split() == ["thesis", "check", "computed", "reference", "thesis's", "error",
                            "allowed"]  # fmt: skip
    assert row.split() == ["nowhere", "a", "half", "0.5", "0.5", "0.51", "0.0e+00", "0e+00", "pass"]
    assert last == "1 checks passed"


def test_failure_has_exit_code_1(monkeypatch, capsys):
    """0.5 is wrong by a quarter of 0.4, more than a fifth."""
    wrong = replace(HALF, reference=0.4, tolerance=0.2)
    assert verify(monkeypatch, HALF, wrong) == 1
    printed = capsys.readouterr().out
    assert "2.5e-01" in printed and "2 checks, 1 failed" in printed


def test_not_a_number_fails(monkeypatch):
    assert verify(monkeypatch, replace(HALF, compute=lambda: float("nan"), tolerance=1.0)) == 1


def test_refusal_fails_with_its_reason(monkeypatch, capsys):
    def refuse() -> float:
        raise CadbemError("no such flow")

    assert verify(monkeypatch, replace(HALF, compute=refuse, tolerance=1.0)) == 1
    assert "FAIL no such flow" in capsys.readouterr().out


def test_error_is_absolute_where_the_truth_is_zero():
    check = replace(HALF, reference=0.0)
    assert check.error(0.5) == 0.5
