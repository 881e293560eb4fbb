#!/usr/bin/python3
"""docs/trajectories.md: every scene of the page runs, every command prints what the page says, and every number that it
quotes is the program's.

usage: trajectories_doc_test.py SALVO REPOSITORY [unittest arguments]
"""
import contextlib
import io
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

SALVO = None
REPOSITORY = None
MOST_SAMPLES = 2000


def blocks(page):
    """The fenced blocks in order: (language, text)."""
    return re.findall(r"^```(\w+)\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)


def printed(value, text):
    """The value with as many digits as the text has, in the text's way of writing numbers."""
    if "e" in text:
        return format(value, f".{len(text.split('e')[0].lstrip('-').replace('.', '')) - 1}e")
    return format(value, f".{len(text.partition('.')[2])}f")


class Page(unittest.TestCase):
    maxDiff = None

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="salvo-page-")
        cls.addClassCleanup(folder.cleanup)
        cls.dir = pathlib.Path(folder.name)
        cls.page = (REPOSITORY / "docs/trajectories.md").read_text()
        cls.blocks = blocks(cls.page)
        cls.scenes = []
        for language, text in cls.blocks:
            if language not in ("toml", "csv"):
                continue
            name = re.match(r"# (\w+\.(?:toml|csv))\n", text)
            if not name:
                raise AssertionError(f"a block does not begin with the name of its file:\n{text}")
            (cls.dir / name[1]).write_text(text)
            if language == "toml":
                cls.scenes.append(name[1])
        # The commands of the page say "salvo".
        (cls.dir / "bin").mkdir()
        (cls.dir / "bin/salvo").symlink_to(SALVO)
        cls.environment = dict(os.environ, PATH=f"{cls.dir / 'bin'}:{os.environ['PATH']}")
        cls.documents = {}

    def salvo(self, *arguments):
        result = subprocess.run([SALVO, *map(str, arguments)], cwd=self.dir, text=True, timeout=300,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, stdin=subprocess.DEVNULL)
        self.assertEqual(result.returncode, 0, f"salvo {arguments}\n{result.stdout}\n{result.stderr}")
        return result.stdout

    def document(self, scene, *arguments):
        """What --json says of a scene, with few samples."""
        few = []
        samples = re.search(r"^samples = ([\d_]+)$", (self.dir / scene).read_text(), re.MULTILINE)
        if samples and int(samples[1].replace("_", "")) > MOST_SAMPLES:
            few = ["--set", f"sweep.samples={MOST_SAMPLES}"]
        key = (scene, *arguments)
        if key not in self.documents:
            self.documents[key] = json.loads(
                self.salvo("run", scene, "--json", "--out", f"json{len(self.documents)}", *few, *arguments))
        return self.documents[key]

    def assert_quoted(self, value, text):
        """The page says this number, and it is the program's to the printed digits."""
        self.assertIn(text, self.page)
        self.assertEqual(printed(value, text), text)

    def test_every_scene_is_valid_and_runs(self):
        self.assertGreaterEqual(len(self.scenes), 8)
        self.assertEqual(len(self.scenes), len(set(self.scenes)))
        for scene in self.scenes:
            with self.subTest(scene):
                self.salvo("validate", scene)
                document = self.document(scene)
                self.assertEqual(document["status"], "done")
                self.assertEqual(document["statistics"]["outcomes"]["not finite"], 0)
                self.assertEqual(document["statistics"]["counted"], document["rows"])

    def assert_output(self, text, said, command):
        """The page's lines are among those of the output, in their order, without a gap but for "..."."""
        lines = [line.rstrip() for line in said.splitlines() if line.strip()]
        at, gap = 0, False
        for line in (line.rstrip() for line in text.splitlines() if line.strip()):
            if line == "...":
                gap = True
                continue
            if gap:
                self.assertIn(line, lines[at:], f"{command}\nprinted\n{said}")
                at = lines.index(line, at)
            self.assertTrue(at < len(lines), f"{command}\nprinted\n{said}")
            self.assertEqual(lines[at], line, f"{command}\nprinted\n{said}")
            at, gap = at + 1, False

    def test_every_command_prints_what_the_page_says(self):
        # In one folder and in order: later commands look at what earlier ones wrote.
        output, command, commands = None, None, 0
        for language, text in self.blocks:
            if language == "sh":
                commands += 1
                result = subprocess.run(["sh", "-ec", text], cwd=self.dir, env=self.environment, text=True, timeout=600,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, stdin=subprocess.DEVNULL)
                self.assertEqual(result.returncode, 0, f"{text}\n{result.stdout}\n{result.stderr}")
                output, command = result.stdout, text
            elif language == "python":
                output, command = self.run_python(text), text
            elif language == "text" and output is not None:
                rest = text if text.rstrip().endswith("...") else text + "...\n"
                self.assert_output(rest, output, command)
                output = None
        self.assertGreaterEqual(commands, 12)

    def run_python(self, text):
        said = io.StringIO()
        before = os.getcwd()
        os.chdir(self.dir)
        try:
            with contextlib.redirect_stdout(said):
                exec(compile(text, "docs/trajectories.md", "exec"), {})  # pylint: disable=exec-used
        finally:
            os.chdir(before)
        return said.getvalue()

    def test_one_shot(self):
        row = self.document("shot.toml")["trajectories"][0]
        self.assertEqual(row["outcome"], "ground")
        self.assert_quoted(row["time"], "4.0245631")
        self.assert_quoted(row["end.x"], "108.57385")
        self.assert_quoted(row["apex.time"], "1.8569038")
        self.assert_quoted(row["apex.x"], "59.256474")
        self.assert_quoted(row["apex.y"], "20.727501")

    def test_grid_and_table(self):
        rows = self.document("grid.toml")["trajectories"]
        self.assertEqual([row["input.speed"] for row in rows], [40] * 3 + [45] * 3)
        for row, text in zip(rows, ["78.005806", "93.3791", "98.702927", "91.657819", "108.57385", "113.91814"]):
            self.assert_quoted(row["end.x"], text)
        rows = self.document("loads.toml")["trajectories"]
        for row, speed, coefficient, drop in zip(rows, ["807.72", "792.48"], ["153.26917", "170.84591"],
                                                 ["-1.114107", "-1.1207531"]):
            self.assert_quoted(row["input.speed"], speed)
            self.assert_quoted(row["input.ballistic_coefficient"], coefficient)
            self.assert_quoted(row["end.y"], drop)

    def test_zero(self):
        document = self.document("zero.toml")
        self.assertEqual(document["solved"][0]["input"], "elevation")
        self.assert_quoted(document["solved"][0]["value"], "0.00293836182969")
        samples = document["trajectories"][0]["samples"]
        for x, level in zip(samples["x"], [100, 200, 300, 400, 500, 600], strict=True):
            self.assertAlmostEqual(x, level, 10)
        self.assertLess(abs(samples["y"][2]), 1e-8)
        for level, text in ((0, "0.16146371"), (1, "0.18918187"), (3, "-0.4467455"), (4, "-1.2015765"), (5, "-2.3282904")):
            self.assert_quoted(samples["y"][level], text)

    def test_aim(self):
        document = self.document("aim.toml")
        for solved, name, text in zip(document["solved"], ["elevation", "azimuth"],
                                      ["0.00673556601651", "-0.00158577414081"]):
            self.assertEqual(solved["input"], name)
            self.assert_quoted(solved["value"], text)
        row = document["trajectories"][0]
        self.assertLess(abs(row["end.y"]) + abs(row["end.z"]), 1e-10)
        calm = self.document("aim.toml", "--set", "solve.0.with={wind_z=0}", "--set", "solve.1.with={wind_z=0}")
        for solved, text in zip(calm["solved"], ["0.00673550020901", "-4.87110370415e-05"]):
            self.assert_quoted(solved["value"], text)
        self.assert_quoted(calm["trajectories"][0]["end.z"], "0.92223111")

    def test_samples_of_flights(self):
        rows = self.document("flights.toml")["trajectories"]
        self.assertEqual([row["sampled"] for row in rows], [4, 5, 4])
        self.assertEqual(rows[0]["samples"]["time"], [0, 1, 2, 3, None])
        for value, text in zip(rows[0]["samples"]["x"][1:4], ["30.326563", "55.80816", "77.841463"]):
            self.assert_quoted(value, text)

    def test_statistics(self):
        document = self.document("target.toml")
        for solved, text in zip(document["solved"], ["0.00265706535886", "-0.000281884217014"]):
            self.assert_quoted(solved["value"], text)
        told = document["statistics"]
        self.assertEqual(told["outcomes"]["range"], 2000)
        for column, mean, deviation in zip(told["columns"], ["-0.00012922813", "0.00021726523", "647.93528"],
                                           ["0.046501211", "0.068297648", "6.9809328"]):
            self.assert_quoted(column["mean"], mean)
            self.assert_quoted(column["deviation"], deviation)
        plane = told["plane"]
        for part, about_mean, about_aim in (("50", "0.066606", "0.0664695"), ("90", "0.125511", "0.125326"),
                                            ("95", "0.14522", "0.145262")):
            self.assert_quoted(plane["circular_error"][part], about_mean)
            self.assert_quoted(plane["circular_error_of_aim"][part], about_aim)
        self.assert_quoted(plane["ellipse"]["semi_axes"][0], "0.0683205")
        self.assert_quoted(plane["ellipse"]["semi_axes"][1], "0.0464676")
        self.assertEqual(plane["hits"]["count"], 1654)
        self.assert_quoted(100 * plane["hits"]["interval_95"][0], "80.9800")
        self.assert_quoted(100 * plane["hits"]["interval_95"][1], "84.2946")

    def test_the_table_of_tolerances(self):
        rows = re.findall(r"^\| (1e-\d+) \| (\d+) \| ([\d.]+) \| ([\d.]+) \|$", self.page, re.MULTILINE)
        self.assertEqual(len(rows), 5)
        for tolerance, steps, x, time in rows:
            with self.subTest(tolerance):
                row = self.document("shot.toml", "--set", f"integration.absolute_tolerance={tolerance}",
                                    "--set", "integration.relative_tolerance=0")["trajectories"][0]
                self.assertEqual(row["steps"], int(steps))
                self.assert_quoted(row["end.x"], x)
                self.assert_quoted(row["time"], time)

    def test_the_ground_that_answers_an_equation(self):
        # What the page says: with the ground at 0, a shot that falls short has end.y = 0, too.
        ground = ["--set", "projectile.y=0", "--set", "projectile.ground=0"]
        refused = subprocess.run([SALVO, "run", "zero.toml", *ground, "--set", "solve.0.with={range=300}"], cwd=self.dir, text=True, stdout=subprocess.PIPE,
                                 stderr=subprocess.PIPE)
        self.assertEqual(refused.returncode, 3)
        self.assertIn("trajectories end there", refused.stderr)
        right = self.document("zero.toml", *ground, "--set", "solve.0.with={range=300,ground=-1e6}")
        free = self.document("zero.toml", "--set", "projectile.y=0")
        self.assertAlmostEqual(right["solved"][0]["value"], free["solved"][0]["value"], 14)

    def test_the_model_is_the_pendulum(self):
        code = [text for language, text in self.blocks if language == "cpp"]
        self.assertEqual(len(code), 1)
        header = (REPOSITORY / "tests/consumer/pendulum.hpp").read_text()
        self.assertEqual(code[0], header[header.index("template <class V>"):])
        self.assertIn("SALVO_DEFINE_MODEL(pendulum, Pendulum)", (REPOSITORY / "tests/consumer/pendulum.cpp").read_text())

    def test_lines_are_short(self):
        for number, line in enumerate(self.page.splitlines(), 1):
            self.assertLessEqual(len(line), 120, f"line {number}")


if __name__ == "__main__":
    SALVO = os.path.abspath(sys.argv.pop(1))
    REPOSITORY = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main()
