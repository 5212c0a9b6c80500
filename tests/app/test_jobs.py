"""From an upload to the program to load; what a killed server leaves, and what the page is told."""

from __future__ import annotations

import json
import shlex
import threading
from html import escape
from urllib.parse import quote

import pytest

from tests.support.app_client import KLARTEXT, POCKET, REFUSED, app_client
from toolpace import Machine
from toolpace.app.worker import WorkerProcess
from toolpace.common.errors import ToolpaceError
from toolpace.results.write import read_plan

CENTRE = {"option": "compensation", "value": "program", "lines": [9]}
MACHINE = "xyzac-trunnion"
NAME = "a&b;$(x) 'c'.h"
HOSTILE = "<img src=x onerror=alert`1`>"
SHEET = """[stock]
box = [[0, -10, -10], [40, 10, 0]]
[tools.1]
kind = "flat"
diameter = 10
flute_length = 20
teeth = 3
length = 100
"""
SHORT = "G21 G90 G17 G94\nG0 X0 Y0 Z1 A0 C0\nG1 Z0 F1500\nG1 X1\nM2\n"


class Stuck:
    """A worker that is at its task until it is ended, or the server is."""

    def __init__(self) -> None:
        self.begun, self._ended = threading.Event(), threading.Event()

    def carry_out(self, task, tell):
        tell({"step": "planning", "note": ""})
        tell({"step": "planning", "share": 0.5})
        self.begun.set()
        self._ended.wait(30.0)
        self._ended.clear()
        raise ToolpaceError("ended")

    def stop(self):
        self._ended.set()


@pytest.fixture(scope="module")
def app(tmp_path_factory):
    with app_client(tmp_path_factory.mktemp("app")) as client:
        yield client


@pytest.fixture(scope="module")
def planned(app):
    """A part with two jobs that have ended; its name and a comment in it are hostile."""
    part = app.upload(NAME, KLARTEXT.replace("M128\n", f"; {HOSTILE}\nM128\n"))
    jobs = app.start(part, effort="low"), app.start(part, tip_tolerance="0.05mm", feeds="none", effort="low")
    return app.part(part), *(app.job(job) for job in jobs)


def test_a_program_is_inspected_and_planned_as_the_commands_do(app, planned):
    part, usual, wide = planned
    found = part["inspection"]
    assert found["dialect"] == "heidenhain" and found["refused"] == [] and MACHINE in found["machines"]
    assert (wide["verdict"], usual["verdict"], usual["error"]) == ("verified", "verified", "")
    assert wide["duration_s"] < usual["duration_s"]
    row = app.service.project.jobs[usual["id"]].row
    record = read_plan(app.service.project.plans / row.folder)
    assert record.duration_s == usual["duration_s"] and record.program == NAME
    assert (record.effort, record.tip_tolerance_mm) == ("low", 0.01)
    assert wide["command"] == (
        f"toolpace plan {shlex.quote(NAME)} -m {MACHINE} --tip-tolerance 0.05mm --effort low --feed none"
    )


def test_the_report_is_no_page_of_the_app_and_the_program_is_loaded(app, planned):
    _, usual, _ = planned
    report, program = (app.ask("GET", f"/{kind}/{usual['id']}") for kind in ("report", "program"))
    assert escape(NAME) in report.text and report.headers["content-security-policy"].startswith("sandbox")
    assert program.text.startswith("BEGIN PGM POCKET MM") and "F1500" not in program.text
    assert quote(f"a&b;$(x) 'c'-{usual['number']}.h") in program.headers["content-disposition"]
    assert program.headers["content-disposition"].startswith("attachment")


def test_two_plans_are_compared(app, planned):
    _, usual, wide = planned
    name = app.done("POST", "/api/compare", [usual["id"], wide["id"]])["name"]
    app.wait(lambda: next(iter([1] * app.done("GET", f"/api/compare/{name}")["drawn"])))
    assert f"job {wide['number']}: 0.05mm, feeds none" in app.ask("GET", f"/compare/{name}").text
    for jobs in ([], [usual["id"]], [usual["id"], usual["id"]], ["0" * 12, usual["id"]], "all", [[1]]):
        assert app.ask("POST", "/api/compare", str(jobs).replace("'", '"').encode()).status in (400, 404)


def test_a_refused_program_is_cured_by_what_its_message_names(app):
    part = app.upload("pocket.mpf", REFUSED)
    found = app.part(part)
    assert [each["word"] for each in found["inspection"]["refused"]] == ["G41"]
    assert CENTRE in found["inspection"]["cures"]
    app.done("PUT", f"/api/parts/{part}/reading", {**found["reading"], "compensation": "program"})
    assert app.part(part)["inspection"]["refused"] == []


@pytest.mark.parametrize(
    ("name", "text", "cures"),
    [("part.ngc", "G0 X0 Y0 Z0\nG1 X10\nM2\n", [("feed", "3000mm/min")]),
     ("part.ngc", "G21\nG0 X1\nG1 X3 F100\n", [("lenient", None), ("skip-unknown", None)]),
     ("part.ngc", "G21\nG0 X0\nG68 X0 Y0 R30\nG1 X3 F100\nM2\n", [("controller", "fanuc"), ("skip-unknown", None)]),
     ("part.ngc", "G21\nG0 X1 X2\nM2\n", []),
     ("part.csv", "x,y,z,i,j,k\n1,2,3,0,0,1\n2,3,4,0,0,1\n", [("units", "mm")]),
     ("letter.txt", "To whom\nit may concern\n", [("dialect", "gcode")])],
)  # fmt: skip
def test_options_that_messages_name_are_cures(app, name, text, cures):
    found = app.part(app.upload(name, text))["inspection"]
    assert [(each["option"], each["value"]) for each in found["cures"]] == cures, found["refused"]


def test_what_certainly_stops_the_control_is_read_on_where_that_is_chosen(app):
    part = app.upload("part.ngc", "G21\nG0 X1\nG1 X3 F100\n")
    assert app.part(part)["inspection"]["refused"] != []
    app.done("PUT", f"/api/parts/{part}/reading", {"lenient": True})
    assert app.part(part)["inspection"]["refused"] == []


def test_what_is_no_program_is_said_without_the_names_of_folders(app):
    for name, content in (("part.ngc", b""), ("zip.ngc", b"PK\x03\x04" + bytes(300)), ("two words.ngc", b"G1 X1\n")):
        part = app.upload(name, content)
        found = app.part(part)["inspection"]
        assert found["refused"] or found["needs"]
        assert str(app.service.project.root) not in str(found)
        job = app.job(app.start(part))
        assert job["error"].startswith(name) and not job["report"] and not job["program"]
    app.upload("broken.toml", b"[tools", part)
    assert app.part(part)["inspection"]["error"].startswith("broken.toml")


def test_files_go_where_their_content_says(app):
    assert app.ask("POST", "/api/files?name=sheet.toml", b"[part]\n").status == 400
    part = app.upload("pocket.ngc", SHORT)
    own = Machine.load(MACHINE).to_toml()
    assert "built-in" in app.ask("POST", "/api/files?name=mill.toml", own.encode()).text
    named = own.replace(f'name = "{MACHINE}"', 'name = "../mill"', 1)
    assert app.ask("POST", "/api/files?name=mill.toml", named.encode()).status == 400
    app.upload("mill.toml", named.replace("../mill", "my mill"))
    app.upload("sheet.toml", "[tools.1]\nlength = 120\n", part)
    app.upload("sub.ngc", "o1 sub\no1 endsub\n", part)
    found = app.part(part)
    assert (found["sheet"], found["beside"]) == ("sheet.toml", ["sub.ngc"])
    assert "my mill" in app.state()["machines"] and "my mill" in found["inspection"]["machines"]


def test_a_sheet_is_written_to_fill_in_with_the_mesh_that_was_dropped(app):
    part = app.upload("pocket.ngc", POCKET)
    app.upload("stock.stl", "solid\nendsolid\n", part)
    app.done("POST", f"/api/parts/{part}/sheet")
    app.wait(lambda: next(iter([1] * bool(app.part(part)["sheet"]))))
    text = app.done("GET", f"/api/parts/{part}/sheet")["text"]
    assert "[tools.1]" in text and '[stock]\nmesh = "stock.stl"' in text
    app.ask("PUT", f"/api/parts/{part}/sheet", b"")
    assert app.part(part)["sheet"] == ""


def test_hostile_names_and_words_stay_data(app, planned):
    assert shlex.split(planned[1]["command"])[2] == NAME
    assert HOSTILE not in app.ask("GET", f"/report/{planned[1]['id']}").text
    assert app.ask("GET", "/").text.count("<script") == 1


def test_two_jobs_wait_for_each_other_and_the_page_says_so(tmp_path):
    stuck = Stuck()
    with app_client(tmp_path, stuck) as app:
        part = app.upload("pocket.ngc", SHORT)
        first, second, third = (app.start(part) for _ in range(3))
        assert stuck.begun.wait(10.0)
        told = {job["id"]: (job["state"], job["before"]) for job in app.state()["jobs"]}
        assert told == {first: ("running", 0), second: ("waiting", 1), third: ("waiting", 2)}
        steps = next(job["steps"] for job in app.state()["jobs"] if job["id"] == first)
        assert steps == [{"step": "planning", "note": "", "share": 0.5}]
        app.done("POST", f"/api/jobs/{second}/stop")
        assert app.job(second)["state"] == "stopped"
        stuck.begun.clear()
        app.done("POST", f"/api/jobs/{first}/stop")
        assert app.job(first)["state"] == "stopped" and stuck.begun.wait(10.0)
        assert app.ask("DELETE", f"/api/jobs/{third}").status == 400
        app.done("DELETE", f"/api/jobs/{second}")
        app.done("DELETE", f"/api/parts/{part}")
        assert app.state()["parts"] == app.state()["jobs"] == []


def test_what_had_not_ended_goes_on_with_the_next_start(tmp_path):
    stuck = Stuck()
    with app_client(tmp_path, stuck) as app:
        part = app.upload("pocket.ngc", SHORT)
        job = app.start(part, effort="low")
        assert stuck.begun.wait(10.0)
    (tmp_path / ".upload-half").write_text("G0")
    (tmp_path / "parts" / "0123456789ab" / "files").mkdir(parents=True)
    with app_client(tmp_path) as app:
        assert app.job(job)["verdict"] == "verified"
        assert [each["id"] for each in app.state()["parts"]] == [part]
    assert not (tmp_path / ".upload-half").exists() and not (tmp_path / "parts" / "0123456789ab").exists()
    with app_client(tmp_path, Stuck()) as app:
        assert app.job(job)["verdict"] == "verified"
        app.done("DELETE", f"/api/jobs/{job}")
        assert list(tmp_path.glob("plans/[!.]*")) == []


def test_a_link_that_was_put_in_place_of_a_result_leads_nowhere(tmp_path, app, planned):
    job = planned[2]["id"]
    report = app.service.report(job)
    kept, folder = report.read_bytes(), report.parent
    report.unlink()
    assert app.ask("GET", f"/report/{job}").status == 404
    (tmp_path / "secret").write_text("secret")
    report.symlink_to(tmp_path / "secret")
    assert app.ask("GET", f"/report/{job}").status == 404
    report.unlink()
    folder.rename(tmp_path / "moved")
    folder.symlink_to(tmp_path / "moved")
    (tmp_path / "moved" / "report.html").write_text("secret")
    assert app.ask("GET", f"/report/{job}").status == 404
    folder.unlink()
    (tmp_path / "moved").rename(folder)
    report.write_bytes(kept)
    assert app.ask("GET", f"/report/{job}").status == 200


BENDS = "[tool]\ndiameter = '6 mm'\nteeth = 2\n[bending]\nstiffness = '20 N/um'\n[cutting]\nforce = [100, 0, 0]\n"


def test_what_feeds_by_the_cut_need_is_told_before_they_are_chosen(tmp_path):
    stuck = Stuck()
    with app_client(tmp_path, stuck) as app:
        part = app.upload("face.ngc", "G21 G90 G94\nT1 M6\nG43.4 H1\nG0 X0 Y0 Z30 A0 C0\nG1 Z-2 F600\nG1 X40\nM2\n")
        assert app.part(part)["inspection"]["cut_lacks"] == ["a stock", "the shape of tool 1"]
        app.upload("sheet.toml", SHEET, part)
        assert app.part(part)["inspection"]["cut_lacks"] == []
        for more, told in (
            ({}, "no limit"), ({"limits": "chips=1"}, "chip"), ({"limits": "force=400N"}, "material"),
            ({"limits": "force=400N", "material": "/etc/passwd"}, "material '/etc/passwd' is not known"),
        ):  # fmt: skip
            request = {"machine": MACHINE, "feeds": "limits", **more}
            answer = app.ask("POST", f"/api/parts/{part}/jobs", json.dumps(request).encode())
            assert answer.status == 400 and told in answer.text
        job = app.start(part, feeds="limits", limits="chip=0.08mm, 1:force=400N", material="al7075-t6")
        command = next(each["command"] for each in app.state()["jobs"] if each["id"] == job)
        assert "--limit chip=0.08mm --limit 1:force=400N --material al7075-t6" in command


def test_a_tool_that_bends_is_compensated_where_its_file_is_there(tmp_path):
    with app_client(tmp_path, Stuck()) as app:
        part = app.upload("pocket.ngc", SHORT)
        request = json.dumps({"machine": MACHINE, "bend": True}).encode()
        answer = app.ask("POST", f"/api/parts/{part}/jobs", request)
        assert answer.status == 400 and "tool that bends" in answer.text
        app.upload("cutter.toml", BENDS, part)
        assert app.part(part)["tool"] == "cutter.toml" and app.part(part)["sheet"] == ""
        app.start(part, bend=True)
        assert "--bend cutter.toml" in app.state()["jobs"][-1]["command"]


@pytest.mark.sweep
def test_feeds_by_the_cut_are_planned_and_loaded(tmp_path):
    """In air before and behind a box of 40 mm; without the tool on the sheet it is one line, with its cure."""
    way = "G21 G90 G17 G94\nT1 M6\nS8000 M3\nG43.4 H1\nG0 X-60 Y0 Z30 A0 C0\nG1 Z-2 F600\nG1 X100\nG0 Z30\nM2\n"
    with app_client(tmp_path) as app:
        part = app.upload("face.ngc", way)
        lacks = app.job(app.start(part, feeds="air", effort="low"))
        assert lacks["error"].startswith("face.ngc:6: tool 1 is not on the sheet") and not lacks["report"]
        app.upload("sheet.toml", SHEET, part)
        usual, air = (app.job(app.start(part, effort="low", **more)) for more in
                      ({}, {"feeds": "air", "air_feed": "3000mm/min"}))
        assert (air["verdict"], air["error"]) == ("verified", "") and air["duration_s"] < 0.75 * usual["duration_s"]
        text = app.ask("GET", f"/program/{air['id']}").text
        assert "F3000" in text and "F600" in text and text.count("\n") > way.count("\n")
        page = app.ask("GET", f"/feeds/{air['id']}")
        assert page.status == 200 and page.headers["content-security-policy"].startswith("sandbox")
        assert "face.ngc" in page.text and str(tmp_path) not in page.text
        assert "toolpace feeds face.ngc" in air["command"] and "--air-feed 3000mm/min" in air["command"]
        assert app.ask("GET", f"/feeds/{usual['id']}").status == 404
        limited = app.job(app.start(part, effort="low", feeds="limits", limits="chip=0.02mm"))
        assert (limited["verdict"], limited["error"]) == ("verified", "") and limited["feeds_page"]
        assert "--feeds limits" in limited["command"] and "--limit chip=0.02mm" in limited["command"]


@pytest.mark.sweep
def test_a_process_that_dies_is_an_error_and_the_next_task_has_another(tmp_path):
    worker = WorkerProcess(tmp_path)
    with app_client(tmp_path, worker) as app:
        part = app.upload("part.ngc", "G21\nG0 X0 Y0 Z0\n" + "G1 X10 F100\nG1 X0\n" * 2000 + "M2\n")
        app.part(part)
        dies, stops, left = (app.start(part, effort="low") for _ in range(3))

        def begun(job):
            app.wait(lambda: next(each for each in app.state()["jobs"] if each["id"] == job and each["steps"]))
            return worker._process

        begun(dies).kill()
        assert "has ended" in app.job(dies)["error"]
        begun(stops)
        app.done("POST", f"/api/jobs/{stops}/stop")
        assert (app.job(stops)["state"], app.job(stops)["error"]) == ("stopped", "")
        last = begun(left)
    assert last.poll() is not None and not list(tmp_path.glob("plans/*/plan.json"))
