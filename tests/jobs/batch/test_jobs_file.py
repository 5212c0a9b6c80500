"""Files of jobs: lists are one job an entry, and what is misspelt is refused with its cure."""

from __future__ import annotations

import math

import pytest

from toolpace.common.errors import UsageError
from toolpace.jobs.batch.jobs_file import jobs_of_file


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "parts").mkdir()
    for name in ("a.ngc", "b.mpf", "c.pdf", ".hidden.ngc"):
        (tmp_path / "parts" / name).write_text("M30\n")
    return tmp_path


def jobs(folder, text):
    (folder / "jobs.toml").write_text(text)
    return jobs_of_file(folder / "jobs.toml")


def test_a_job_for_each_combination(folder):
    found = jobs(
        folder,
        """
        [all]
        machine = ["xyzac-trunnion", "my-mill.toml"]
        report = false
        [[jobs]]
        programs = "parts"
        tip_tolerance = ["5um", "0.02mm"]
        axis_tolerance = "0.1deg"
        [[jobs]]
        programs = ["parts/*.ngc", "elsewhere.nc"]
        machine = "xyzbc-head"
        what = "export"
        to = "table"
        dt = "2ms"
        export = { period = 0.004, columns = ["t", "q"] }
        """,
    )
    named = [
        (job.program.removeprefix(str(folder) + "/"), job.machine.removeprefix(str(folder) + "/")) for job in found
    ]
    assert named == [
        *[(part, machine) for part in ("parts/a.ngc", "parts/b.mpf")
          for machine in ("xyzac-trunnion", "my-mill.toml") for _ in range(2)],
        ("parts/a.ngc", "xyzbc-head"), ("elsewhere.nc", "xyzbc-head"),
    ]  # fmt: skip
    assert [job.tip_tolerance for job in found[:2]] == [pytest.approx(5e-6), pytest.approx(2e-5)]
    assert found[0].axis_tolerance == pytest.approx(math.radians(0.1)) and not found[-1].report
    assert found[-1].dt == 2e-3 and found[-1].export == {"period": 0.004, "columns": ("t", "q")}
    assert found[1].machine == "xyzac-trunnion" and found[2].machine == str(folder / "my-mill.toml")


@pytest.mark.parametrize(
    "text, message",
    [
        ("", r"jobs are missing; .*\[\[jobs\]\]"),
        ("[jobs]\nprograms = 'a'", r"jobs are missing"),
        ("[al]\n[[jobs]]\nprograms = 'a'", "the unknown key 'al'; did you mean 'all'?"),
        ("[[jobs]]\nprogram = 'a'", r"\[\[jobs\]\] number 1 has the unknown key 'program'; did you mean 'programs'?"),
        ("[[jobs]]\nmachine = 'xyzac-trunnion'", "has no programs"),
        ("[[jobs]]\nprograms = 'parts/*.nothing'\nmachine = 'x'", "nothing there fits"),
        ("[[jobs]]\nprograms = 'parts'", "parts/a.ngc: the machine is missing"),
        ("[[jobs]]\nprograms = 'parts'\nmachine = []", r"machine = \[\] leaves nothing to do"),
        ("[[jobs]]\nprograms = 'parts'\nmachine = 'x'\ntip_tolerance = 0.01", "= 0.01: write it with its unit"),
        ("[[jobs]]\nprograms = 'parts'\nmachine = 'x'\ntip_tolerance = '0.01'", "tip_tolerance: .*unit"),
        ("[[jobs]]\nprograms = 'parts'\nmachine = 'x'\ntip_tolerance = '10m'", "= 10.0: give a value from"),
        ("[[jobs]]\nprograms = 'parts'\nmachine = 'x'\nplanner = 'optimum'", "did you mean 'optimal'"),
        ("[[jobs]]\nprograms = 'parts'\nmachine = 'x'\nwhat = ['plan', 'time']", "what is a list"),
        ("[[jobs]]\nprograms = 'parts'\nmachine = 'x'\nreport = 1", "report = 1: write true or false"),
        ("[[jobs]]\nprograms = 'parts'\nmachine = 'x'\nfeed = 'fast'", "feed"),
        ("[[jobs]]\nprograms = 'parts'\nmachine = 'x'\nmax_blocks = 0", "max_blocks = 0"),
        ("[[jobs]\n", "not a TOML file"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named_with_its_cure(folder, text, message):
    with pytest.raises(UsageError, match=message) as error:
        jobs(folder, text)
    assert str(error.value).startswith(str(folder / "jobs.toml")) and "\n" not in str(error.value)
