#!/usr/bin/python3
"""The salvo command as a user meets it: every verb, exit statuses, messages, suggestions, what is on stdout, and that runs
which were interrupted or killed go on to the same files.

usage: cli_test.py SALVO [unittest arguments]
"""
import json
import os
import pathlib
import pty
import re
import resource
import shlex
import signal
import subprocess
import sys
import tempfile
import time
import unittest

SALVO = None

# 1501 particles (no multiple of anything) in two bursts and a jet, on a floor: 200 steps, a frame every 20.
SCENE = """\
title = "a test"
seed = 5
[time]
dt = 0.005
steps = 200
[forces]
quadratic_drag = true
[[obstacle]]
shape = "plane"
[[emitter]]
kind = "burst"
count = 1001
position = [0, 1, 0]
speed = { uniform = [2, 9] }
radius = 0.01
drag_area = 1e-4
life = { uniform = [0.3, 3] }
[[emitter]]
kind = "jet"
rate = 1000
duration = 0.3
position = [1, 1, 0]
direction = [0, 1, 0]
speed = 3
drag_area = 1e-4
[[emitter]]
kind = "burst"
count = 200
time = 0.25
position = [0, 2, 0]
speed = 4
drag_area = 2e-4
[frames]
every = 20
columns = ["id", "position", "velocity"]
"""

# Long enough to be interrupted: a hundred frames of some tens of milliseconds each with the slowest kernels.
LONG = SCENE.replace("count = 1001", "count = 8009").replace("[0.3, 3]", "[0.3, 30]").replace("steps = 200", "steps = 2000")
SLOWLY = ["--isa", "scalar", "--threads", "1", "--pass", "1"]


# Enough rows for the example of one of them, and of shards.
TRAJECTORIES = """\
title = "a sweep"
[boat]
thrust = { normal = [20000, 100] }
[sweep]
samples = 200_000
[integration]
method = "runge_kutta_4"
step = 0.5
time_limit = 1
"""


class Case(unittest.TestCase):
    maxDiff = None

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="salvo-cli-")
        self.addCleanup(folder.cleanup)
        self.dir = pathlib.Path(folder.name)
        self.write("scene.toml", SCENE)
        self.environment = {k: v for k, v in os.environ.items() if k not in ("NO_COLOR", "TERM")}

    def write(self, name, text):
        (self.dir / name).write_text(text)
        return name

    def salvo(self, *arguments, status=0, **options):
        """Runs the command in the test's folder; checks its exit status."""
        result = subprocess.run([SALVO, *map(str, arguments)], cwd=self.dir, text=True, timeout=300,
                                stdout=options.pop("stdout", subprocess.PIPE), stderr=subprocess.PIPE,
                                stdin=subprocess.DEVNULL, env=self.environment, **options)
        self.assertEqual(result.returncode, status, f"salvo {arguments}\n{result.stdout}\n{result.stderr}")
        return result

    def document(self, *arguments, status=0, **options):
        """What --json prints; json.loads refuses a second document or anything else beside it."""
        return json.loads(self.salvo(*arguments, "--json", status=status, **options).stdout)

    def start(self, *arguments, **options):
        return subprocess.Popen([SALVO, *arguments], cwd=self.dir, text=True, env=self.environment,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options)

    def wait_for(self, path, process):
        """Until a file is there, while the process is at work."""
        deadline = time.monotonic() + 120
        while not (self.dir / path).exists():
            if process.poll() is not None or time.monotonic() > deadline:
                self.fail(f"{path} did not appear: {process.communicate()}")
            time.sleep(0.005)

    def recording(self, folder):
        """The files of a recording, without run.json, which alone may differ between equal runs."""
        return {path.name: path.read_bytes() for path in (self.dir / folder).iterdir()
                if path.name != "run.json" and not path.name.startswith(".")}

    def assert_same_recording(self, a, b):
        first, second = self.recording(a), self.recording(b)
        self.assertEqual(sorted(first), sorted(second))
        self.assertGreater(len(first), 3)
        for name, content in first.items():
            self.assertTrue(content == second[name], f"{a}/{name} differs from {b}/{name}")


class Usage(Case):
    def assert_usage(self, arguments, problem, hint):
        result = self.salvo(*arguments, status=2)
        self.assertEqual(result.stdout, "")
        self.assertEqual(result.stderr, f"salvo: error: {problem}\n  {hint}\n")

    def test_help_without_arguments_and_by_every_name(self):
        text = self.salvo().stdout
        self.assertTrue(text.startswith("salvo: "))
        for verb in ("run", "verify", "validate", "info", "hash", "export"):
            self.assertRegex(text, rf"\n  {verb} ")
            own = self.salvo(verb, "--help").stdout
            self.assertIn(f"usage: salvo {verb} ", own)
            self.assertIn("examples:", own)
            self.assertEqual(own, self.salvo("help", verb).stdout)
            self.assertEqual(own, self.salvo(verb, "scene.toml", "-h").stdout)
        for arguments in (["--help"], ["-h"], ["help"]):
            self.assertEqual(self.salvo(*arguments).stdout, text)
        self.assertLess(text.count("\n"), 30)

    def test_version(self):
        self.assertRegex(self.salvo("--version").stdout, r"^salvo \d+\.\d+\.\d+\n$")

    def test_mistyped_commands_and_options_get_a_suggestion(self):
        self.assert_usage(["rnu", "scene.toml"], 'unknown command "rnu"', 'did you mean "run"?')
        self.assert_usage(["exprot"], 'unknown command "exprot"', 'did you mean "export"?')
        self.assert_usage(["frobnicate"], 'unknown command "frobnicate"', "salvo --help lists the commands")
        self.assert_usage(["help", "verfy"], 'unknown command "verfy"', 'did you mean "verify"?')
        self.assert_usage(["run", "scene.toml", "--treads", "2"], 'unknown option "--treads" of salvo run',
                          'did you mean "--threads"?')
        self.assert_usage(["run", "--treads=2", "scene.toml"], 'unknown option "--treads" of salvo run',
                          'did you mean "--threads"?')
        self.assert_usage(["hash", "scene.toml", "--zzz"], 'unknown option "--zzz" of salvo hash',
                          "salvo hash --help lists its options")
        self.assert_usage(["--verison"], 'unknown option "--verison"', 'did you mean "--version"?')

    def test_what_is_in_the_wrong_place(self):
        self.assert_usage(["--threads", "2", "run", "scene.toml"], "--threads stands in front of the command",
                          "write: salvo run SCENE --threads ...")
        self.assert_usage(["scene.toml"], 'unknown command "scene.toml"', "did you mean: salvo run scene.toml?")
        self.assert_usage(["run", "scene.toml", "seed=3"], 'unexpected argument "seed=3"',
                          "did you mean --set seed=3? Each change has a --set of its own")
        self.assert_usage(["run", "scene.toml", "other"], 'unexpected argument "other"',
                          "usage: salvo run SCENE [OPTIONS]")
        self.assert_usage(["run"], "salvo run needs a scene", "for example: salvo run scenes/explosion.toml")
        self.assert_usage(["export"], "salvo export needs a recording",
                          "for example: salvo export out/explosion --format csv")

    def test_values(self):
        where = ["run", "scene.toml"]
        self.assert_usage([*where, "--threads"], "--threads needs a value",
                          "--threads N: number of threads; the machine's by default")
        self.assert_usage([*where, "--out", "--json"][:3] + ["--quiet"], "--out needs a value",
                          "--out DIR: where to record; out/NAME OF THE SCENE by default")
        self.assert_usage([*where, "--threads", "2", "--threads", "3"], "--threads is given 2 times", "give it once")
        self.assert_usage([*where, "--threads", "2,3"], "--threads has 2 entries",
                          "a list is for salvo verify; here it takes one")
        self.assert_usage([*where, "--set", "seed"], "--set seed: expected KEY=VALUE",
                          "for example: --set time.dt=1e-3")
        self.assert_usage([*where, "--resume", "--force"], "--resume keeps what --force replaces", "give one of them")
        for value in ("0", "-1", "two", "1.5", "99999999999999999999", ""):
            result = self.salvo(*where, "--threads", value, status=2)
            if value:
                self.assertEqual(result.stderr, f"salvo: error: --threads {value}: expected a whole number "
                                                "from 1 to 1024\n")
        self.salvo(*where, "--pass", "0", status=2)
        self.salvo(*where, "--json=3", status=2)
        self.assertFalse((self.dir / "out").exists())

    def test_instruction_sets(self):
        has = self.document("info")["isas"]
        said = "This machine runs " + ", ".join(has)
        self.assert_usage(["run", "scene.toml", "--isa", "sclar"], 'unknown instruction set "sclar"',
                          f'did you mean "scalar"? {said}')
        self.assert_usage(["run", "scene.toml", "--isa", "mmx"], 'unknown instruction set "mmx"', said)
        lacks = next(isa for isa in ("neon", "sse2") if isa not in has)
        self.assert_usage(["verify", "scene.toml", "--isa", f"scalar,{lacks}"],
                          f"this machine cannot run {lacks} kernels", said)

    def test_every_example_of_the_help_runs(self):
        verbs = ("run", "verify", "validate", "info", "hash", "export", "merge")
        texts = [self.salvo("--help").stdout, *(self.salvo(verb, "--help").stdout for verb in verbs)]
        examples = [line[2:].split("   ")[0] for text in texts
                    for line in text.split("examples:\n")[1].split("\n\n")[0].splitlines()]
        self.assertGreater(len(examples), 12)
        changes = re.search(r"such as (\S+) or (\S+)$", self.salvo("run", "--help").stdout, re.MULTILINE)
        examples += [f"salvo validate scenes/explosion.toml --set {change}" for change in changes.groups()]
        for i, example in enumerate(examples):
            with self.subTest(example):
                folder = self.dir / str(i)
                (folder / "scenes").mkdir(parents=True)
                (folder / "scenes/explosion.toml").write_text(SCENE.replace("every = 20", "every = 10")
                                                            .replace("steps = 200", "duration = 1"))
                (folder / "scenes/dispersion.toml").write_text(TRAJECTORIES)
                command = example.replace("/data", str(folder))
                if " export " in example:
                    scene = re.search(r"out/(\w+)", example)[1]
                    command = f"salvo run scenes/{scene}.toml && {command}"
                if " merge " in example:
                    command = "".join(f"salvo run scenes/dispersion.toml --shard {i}/2 --out {folder}/shard{i} && "
                                      for i in (1, 2)) + command
                result = subprocess.run(command.replace("salvo ", f"{shlex.quote(SALVO)} "), shell=True, cwd=folder,
                                        text=True, capture_output=True, timeout=300)
                self.assertEqual(result.returncode, 0, result.stderr)

    def test_what_info_would_ignore(self):
        self.assert_usage(["info", "--keys", "none.toml"], "--keys lists the keys of every scene",
                          "leave out the scene, or --keys")
        self.assert_usage(["info", "--set", "seed=1"], "--set changes a scene, and none is given",
                          "name it: salvo info SCENE --set ...")

    def test_an_end_of_options(self):
        self.write("-odd.toml", SCENE)
        self.assertIn("-odd.toml: valid", self.salvo("validate", "--", "-odd.toml").stdout)

    def test_errors_are_one_document_too(self):
        for arguments, status in ((["rnu"], 2), (["run", "none.toml"], 4), (["run", "bad.toml"], 3)):
            self.write("bad.toml", SCENE.replace("speed = 3", "sped = 3"))
            document = self.document(*arguments, status=status)
            self.assertEqual((document["status"], document["exit_status"]), ("failed", status))
            self.assertTrue(document["error"]["message"])


class Scenes(Case):
    def test_valid(self):
        result = self.salvo("validate", "scene.toml")
        self.assertEqual(result.stdout, "scene.toml: valid, 1,501 particles, 200 steps\n")
        self.assertEqual(result.stderr, "")
        self.assertTrue(self.document("validate", "scene.toml")["scenes"][0]["valid"])

    def test_mistakes_are_said_at_once_with_place_and_suggestion(self):
        self.write("bad.toml", SCENE.replace("speed = 3", "sped = 3").replace("dt = 0.005", "dt = -1"))
        for verb in ("validate", "run", "verify", "hash", "info"):
            result = self.salvo(verb, "bad.toml", status=3)
            self.assertEqual(result.stdout, "")
            line = SCENE.split("\n").index("speed = 3") + 1
            self.assertIn(f'bad.toml:{line}:1: error: unknown key "sped"', result.stderr)
            self.assertIn('^^^^ did you mean "speed"?', result.stderr)
            self.assertIn("bad.toml:4:", result.stderr)
        self.assertEqual([path.name for path in self.dir.iterdir() if path.is_dir()], [])
        document = self.document("validate", "scene.toml", "bad.toml", status=3)
        self.assertEqual([scene["valid"] for scene in document["scenes"]], [True, False])
        self.assertEqual(len(document["scenes"][1]["mistakes"]), 2)

    def test_a_scene_that_is_not_there(self):
        result = self.salvo("run", "scent.toml", status=4)
        self.assertEqual(result.stderr, "salvo: error: cannot read scent.toml: No such file or directory\n"
                                        "  did you mean scene.toml?\n")
        self.salvo("validate", "nothing-like-it", status=4)

    def test_changes_by_set(self):
        self.assertIn("1,000 particles", self.salvo("validate", "scene.toml", "--set", "emitter.0.count=500",
                                                    ).stdout)
        self.assertIn("100 steps", self.salvo("validate", "scene.toml", "--set", "time.steps=100").stdout)
        result = self.salvo("validate", "scene.toml", "--set", "time.stpes=10", status=3)
        self.assertIn('did you mean "steps"?', result.stderr)
        hashes = [self.document("hash", "scene.toml", "--set", f"seed={seed}")["state_hash"] for seed in (5, 6)]
        self.assertEqual(hashes[0], self.document("hash", "scene.toml")["state_hash"])
        self.assertNotEqual(*hashes)

    def test_info(self):
        text = self.salvo("info", "scene.toml").stdout
        for part in ("a test", "1,501", "200 steps", "plane", "gravity, quadratic drag", "jet", "memory"):
            self.assertIn(part, text)
        document = self.document("info", "scene.toml")
        self.assertEqual(document["particles"], 1501)
        self.assertEqual(document["frames"]["count"], 11)
        self.assertEqual([emitter["particles"] for emitter in document["emitters"]], [1001, 300, 200])
        self.assertGreater(document["memory_bytes"], 1501 * 36)
        machine = self.document("info")
        self.assertIn("scalar", machine["isas"])
        self.assertRegex(machine["libraries"], r"HDF5 1\.\d+")
        self.assertIn("contract", self.salvo("info").stdout)
        keys = self.salvo("info", "--keys").stdout
        for key in ("quadratic_drag", "speed", "fraction"):
            self.assertIn(key, keys)
        listed = {(key["section"], key["key"]): key for key in self.document("info", "--keys")["keys"]}
        self.assertEqual(listed["frames", "fraction"]["default"], "1")
        self.assertEqual(listed["emitter", "speed"]["unit"], "m/s")
        self.assertTrue(listed["emitter", "kind"]["required"])
        self.assertIn("jet", listed["emitter", "kind"]["words"])

    def test_info_tells_the_size_of_the_recording(self):
        # All are alive all the time; a fraction of them is recorded.
        self.write("all.toml", re.sub(r"life = .*\n", "", SCENE).replace("rate = 1000\nduration", "rate = 9\nduration")
                   .replace("time = 0.25", "time = 0") + "fraction = 0.3\n")
        said = self.document("info", "all.toml")
        self.salvo("run", "all.toml")
        files = [path.stat().st_size for path in (self.dir / "out/all").glob("*.hdf")]
        self.assertEqual(len(files), said["frames"]["count"] + said["checkpoints"]["count"])
        self.assertLess(abs(sum(files) - said["bytes"]), 0.1 * sum(files))

    def test_info_says_when_a_killed_run_starts_again(self):
        again = "when killed, it starts again at step 0"
        self.assertIn(again, self.salvo("info", "scene.toml").stdout)
        self.assertNotIn(again, self.salvo("info", "scene.toml", "--set", "checkpoint.every=100").stdout)
        complete = "frames.columns=['id', 'position', 'velocity', 'radius', 'drag_area', 'birth', 'death']"
        self.assertNotIn(again, self.salvo("info", "scene.toml", "--set", complete).stdout)
        shipped = pathlib.Path(__file__).parents[2] / "scenes/explosion.toml"  # the README promises it
        self.assertNotIn(again, self.salvo("info", shipped).stdout)

    def test_a_scene_that_does_not_fit_in_memory(self):
        if os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") > 250e9:
            self.skipTest("this machine holds all particles that a world can have")
        for verb in ("run", "hash", "verify --full"):
            result = self.salvo(*verb.split(), "scene.toml", "--set", "emitter.0.count=4.2e9", status=1)
            self.assertRegex(result.stderr, r"takes [\d.]+ [GT]B of memory for 4,200,000,500 particles, and [\d.]+ "
                                            r"GB are available\n  fewer particles")
        self.assertFalse((self.dir / "out").exists())


class Runs(Case):
    def test_run_records_and_says_what_came_of_it(self):
        result = self.salvo("run", "scene.toml")
        names = sorted(path.name for path in (self.dir / "out/scene").iterdir() if path.name[0] != ".")
        self.assertEqual(names, ["checkpoint_000000200.hdf", *(f"frame_{i:06}.hdf" for i in range(11)),
                                 "frames.hdf.series", "run.json"])
        final = self.document("hash", "scene.toml")["state_hash"]
        self.assertIn(f"state hash  {final} at step 200\n", result.stdout)
        for heading in ("particles", "mass kg", "momentum kg m/s", "kinetic J", "potential J", "lowest m", "highest m",
                        "max speed m/s", "impacts", "rests", "removed"):
            self.assertIn(heading, result.stdout)
        self.assertIn("11 frames, 1 checkpoint, ", result.stdout)
        self.assertIn("salvo export out/scene", result.stderr)
        self.assertEqual(json.loads((self.dir / "out/scene/run.json").read_text())["status"], "done")

    def test_quiet_and_json(self):
        quiet = self.salvo("run", "scene.toml", "-q")
        self.assertEqual(quiet.stderr, "")
        self.assertIn("state hash", quiet.stdout)
        document = self.document("run", "scene.toml", "--out", "elsewhere")
        self.assertEqual((document["status"], document["exit_status"], document["step"]), ("done", 0, 200))
        self.assertEqual([frame["step"] for frame in document["frames"]], list(range(0, 201, 20)))
        self.assertEqual(document["frames"][-1]["hash"], document["state_hash"])
        self.assertEqual(document["frames"][0]["particles"], 1006)
        self.assertEqual(len(document["frames"][0]["momentum"]), 3)
        self.assert_same_recording("out/scene", "elsewhere")

    def test_how_it_runs_changes_no_byte(self):
        self.salvo("run", "scene.toml", "--out", "reference", *SLOWLY)
        isas = self.document("info")["isas"]
        for i, how in enumerate((["--threads", "13"], ["--threads", "3", "--pass", "7"],
                                 *(["--isa", isa] for isa in isas))):
            self.salvo("run", "scene.toml", "--out", f"run{i}", *how)
            self.assert_same_recording("reference", f"run{i}")

    def test_hash_prints_a_line_a_frame(self):
        lines = self.salvo("hash", "scene.toml", "-q").stdout.splitlines()
        self.assertEqual(len(lines), 11)
        for step, line in zip(range(0, 201, 20), lines):
            self.assertRegex(line, rf"^[0-9a-f]{{32}}  step {step}  ")
        document = self.document("hash", "scene.toml", "--threads", "13")
        self.assertEqual([frame["total"] for frame in document["frames"]], [line[:32] for line in lines])
        self.assertIn("velocity", document["frames"][0]["fields"])

    def test_another_scenes_recording_is_not_replaced_unasked(self):
        self.salvo("run", "scene.toml", "--out", "here")
        before = self.recording("here")
        result = self.salvo("run", "scene.toml", "--set", "seed=6", "--out", "here", status=4)
        self.assertIn("--force replaces what is there", result.stderr)
        self.assertEqual(before, self.recording("here"))
        resumed = self.salvo("run", "scene.toml", "--set", "seed=6", "--out", "here", "--resume", status=4)
        self.assertIn("--force replaces what is there", resumed.stderr)
        self.assertEqual(before, self.recording("here"))
        self.salvo("run", "scene.toml", "--set", "seed=6", "--out", "here", "--force")
        self.assertNotEqual(before, self.recording("here"))
        self.salvo("run", "scene.toml", "--set", "seed=6", "--out", "here")  # the same scene again

    def test_force_replaces_nothing_when_memory_does_not_suffice(self):
        limit = lambda: resource.setrlimit(resource.RLIMIT_AS, (600 << 20, 600 << 20))
        if subprocess.run([SALVO, "info"], preexec_fn=limit, capture_output=True).returncode != 0:
            self.skipTest("the program itself takes more, as sanitized ones do")
        self.salvo("run", "scene.toml", "--out", "here")
        before = self.recording("here")
        self.salvo("run", "scene.toml", "--set", "emitter.0.count=2e7", "--out", "here", "--force", status=1,
                   preexec_fn=limit)
        self.assertEqual(before, self.recording("here"))
        self.assertEqual(json.loads((self.dir / "here/run.json").read_text())["status"], "done")

    def test_a_run_that_breaks_names_the_particle_and_stays_readable(self):
        self.write("narrow.toml", SCENE + "[domain]\nlowest = [-100, -100, -100]\nhighest = [100, 2.5, 100]\n")
        result = self.salvo("run", "narrow.toml", status=5)
        message = re.search(r"salvo: error: particle (\d+) \(stream (\d+), serial (\d+)\) left the domain at step "
                            r"(\d+): position\.y = (\S+)\n  recorded so far and readable: (\d+) frames? in out/narrow",
                            result.stderr)
        self.assertTrue(message, result.stderr)
        self.assertGreater(float(message[5]), 2.5)
        self.assertEqual(int(message[4]) // 20 + 1, int(message[6]))
        self.salvo("export", "out/narrow", "--format", "csv")
        error = self.document("run", "narrow.toml", status=5)["error"]
        self.assertEqual((str(error["id"]), str(error["step"]), error["column"]), (message[1], message[4], "position.y"))
        self.assertEqual(json.loads((self.dir / "out/narrow/run.json").read_text())["status"], "failed")
        self.salvo("hash", "narrow.toml", status=5)
        self.salvo("verify", "narrow.toml", status=5)

    def test_removed_particles_are_told(self):
        self.write("leaving.toml", SCENE + "[domain]\nlowest = [-100, -100, -100]\nhighest = [100, 2.5, 100]\n"
                                           "on_leave = \"remove\"\n")
        result = self.salvo("run", "leaving.toml")
        said = re.search(r"salvo: ([\d,]+) particles removed; the first: particle (\d+) .* left the domain at step (\d+): "
                         r"position\.y = ", result.stderr)
        self.assertTrue(said, result.stderr)
        document = self.document("run", "leaving.toml", "--out", "other")
        left = document["removed"]["left_domain"]
        self.assertEqual((f"{left['count']:,}", str(left["first"]["id"]), str(left["first"]["step"])), said.groups())
        self.assertEqual(left["count"], document["frames"][-1]["removed"])
        self.assertEqual(document["removed"]["non_finite"], {"count": 0, "first": None})
        report = json.loads((self.dir / "other/run.json").read_text())["removed"]
        self.assertEqual((report["left_domain"]["count"], report["left_domain"]["first"]["step"]),
                         (left["count"], left["first"]["step"]))

    def test_removed_particles_that_overflowed_are_a_warning(self):
        self.write("overflow.toml", "[time]\ndt = 1\nsteps = 4\n[forces]\ngravity = [0, -1e38, 0]\n[domain]\n"
                                    "on_leave = \"remove\"\n[[emitter]]\nkind = \"burst\"\ncount = 10\n")
        result = self.salvo("run", "overflow.toml", "-q")
        self.assertRegex(result.stderr, r"^salvo: warning: 10 particles removed; the first: particle 0 \(stream 0, serial "
                                        r"0\) became non-finite at step \d: \w+\.y = -?inf\n$")
        removed = self.document("run", "overflow.toml")["removed"]
        self.assertEqual((removed["left_domain"]["count"], removed["non_finite"]["count"]), (0, 10))

    def test_places_that_cannot_be_written(self):
        self.write("file", "")
        result = self.salvo("run", "scene.toml", "--out", "file/out", status=4)
        self.assertIn("file/out", result.stderr)
        with open("/dev/full", "w") as full:
            result = self.salvo("info", "scene.toml", stdout=full, status=4)
        self.assertIn("cannot write to stdout: No space left on device", result.stderr)

    def test_what_is_in_the_way_is_no_full_disk(self):
        (self.dir / "out/scene/frame_000003.hdf").mkdir(parents=True)
        result = self.salvo("run", "scene.toml", status=4)
        self.assertIn("cannot write out/scene/frame_000003.hdf", result.stderr)
        self.assertNotIn("when there is room", result.stderr)

    def test_a_full_disk(self):
        # Stands in for one: no file may grow beyond this. Python's children inherit that SIGXFSZ is ignored.
        limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (70_000, 70_000))
        self.write("long.toml", SCENE.replace("rate = 1000", "rate = 9000") + "[checkpoint]\nat_end = false\n")
        result = self.salvo("run", "long.toml", status=4, preexec_fn=limit, restore_signals=False)
        self.assertRegex(result.stderr, r"recorded so far and readable: \d+ frames? in out/long\n"
                                        r"  to go on when there is room: salvo run long.toml --out out/long --resume\n")
        frames = list((self.dir / "out/long").glob("frame_*.hdf"))
        self.assertGreater(len(frames), 0)
        self.assertLess(len(frames), 11)
        self.salvo("run", "long.toml", "--resume")
        self.salvo("run", "long.toml", "--out", "reference")
        self.assert_same_recording("out/long", "reference")


class Contacts(Case):
    """The scene of docs/contact.md, and what is wrong with changes of it."""

    def setUp(self):
        super().setUp()
        page = (pathlib.Path(__file__).parents[2] / "docs/contact.md").read_text()
        self.write("pour.toml", re.search(r"^```toml\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)[1])

    def test_it_settles_and_says_so(self):
        result = self.salvo("run", "pour.toml", "--profile")
        for part in ("150", "partners each", "overlap max %", "slipped J", "forces and motion", "neighbor lists"):
            self.assertIn(part, result.stdout + result.stderr)
        document = self.document("run", "pour.toml", "--profile", "--out", "again", "--threads", "1", "--isa", "scalar")
        self.assertIn(f"state hash  {document['state_hash']} ", result.stdout)
        first, last = document["frames"][0], document["frames"][-1]
        self.assertEqual((first["particles"], first["pair_contacts"]), (150, 0))
        self.assertGreater(last["pair_contacts"], 150)
        self.assertGreater(last["wall_contacts"], 10)
        self.assertLess(last["kinetic_energy"], 1e-3 * first["potential_energy"])
        energy = [sum(frame[key] for key in ("kinetic_energy", "potential_energy", "rotational_energy", "elastic_energy",
                                             "damping_loss", "friction_loss"))
                  for frame in (first, last)]
        self.assertLess(abs(energy[1] - energy[0]), 1e-3 * (first["potential_energy"] - last["potential_energy"]))
        self.assertLess(max(map(abs, last["momentum_error"])), 1e-5)
        contacts = document["profile"]["contacts"]
        self.assertEqual(contacts["steps"], document["steps"])
        self.assertGreater(contacts["steps_per_build"], 5)

    def test_the_chosen_step_is_explained(self):
        text = self.salvo("info", "pour.toml").stdout
        self.assertIn("linear_spring", text)
        self.assertIn("dt is chosen: 1/50 of the impact of two of the lightest spheres", text)
        result = self.salvo("run", "pour.toml", "--set", "time.dt=1e-3", status=3)
        self.assertRegex(result.stderr, r"dt.*(impact|contact)")

    def test_overlaps_at_birth_are_refused_or_relaxed(self):
        close = ["--set", "emitter.0.spacing=18e-3"]
        for verb in ("run", "hash", "verify"):
            result = self.salvo(verb, "pour.toml", *close, status=3)
            self.assertRegex(result.stderr, r"\d+ pairs overlap when emitted, the worst at step 0 by [\d.]+ % of the smaller "
                                            r"radius: particle \d+ \(stream \d+, serial \d+\) and particle \d+ \(stream \d+, "
                                            r"serial \d+\)\n  a larger spacing, or relax = true")
        self.assertFalse(list((self.dir / "out").glob("*/frame*")))
        relaxed = [*close, "--set", "contact_law.relax=true", "--set", "frames.count=1"]
        document = self.document("run", "pour.toml", *relaxed)
        self.assertLess(document["frames"][0]["max_relative_overlap"], 0.0101)
        self.assertGreater(document["relaxed"]["pairs"], 10)
        self.assertGreater(document["relaxed"]["worst"], 0.1)
        self.assertRegex(self.salvo("run", "pour.toml", *relaxed, "--out", "said").stderr, r"pairs overlap .* moved apart")

    def test_what_cannot_touch(self):
        for change, message in (("emitter.0.spacing=1", "the lattice has no site"),
                                ("emitter.0.radius=0", "radius"),
                                ("emitter.0.mass=-1", "mass"),
                                ("contact_law.normal_stiffness=0", "normal_stiffness"),
                                ("contact_law.restitution=1.5", "restitution")):
            result = self.salvo("run", "pour.toml", "--set", change, status=3)
            self.assertIn(message, result.stderr)
            self.assertIn("error:", result.stderr)

    def test_meshes_that_are_no_surface(self):
        self.write("box.toml", (self.dir / "pour.toml").read_text() + """
[[obstacle]]
shape = "mesh"
file = "wall.obj"
""")
        corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 0\n"
        for faces, message in (("f 1 2 3\nf 1 2 4\nf 1 2 5\n", "edge"), ("f 1 2 2\n", "two corners at (1, 0, 0)"), ("f 1 2 9\n", "9")):
            self.write("wall.obj", corners + faces)
            result = self.salvo("run", "box.toml", status=3)
            self.assertIn("wall.obj", result.stderr)
            self.assertIn(message, result.stderr)
        (self.dir / "wall.obj").unlink()
        self.assertIn("wall.obj", self.salvo("run", "box.toml", status=3).stderr)

    def test_interrupted_amid_contacts(self):
        arguments = ["run", "pour.toml", "--set", "checkpoint.every=1274", "--out"]
        self.salvo(*arguments, "whole")
        arguments.append("parts")
        process = self.start(*arguments, "--isa", "scalar", "--threads", "1")
        self.wait_for("parts/frame_000008.hdf", process)
        process.send_signal(signal.SIGKILL)
        process.wait()
        self.salvo(*arguments, "--resume", "--threads", "13")
        self.assert_same_recording("whole", "parts")


class Interruptions(Case):
    def setUp(self):
        super().setUp()
        self.write("long.toml", LONG)
        self.salvo("run", "long.toml", "--out", "whole")

    def interrupted(self, frame, number=signal.SIGINT):
        process = self.start("run", "long.toml", "--out", "part", *SLOWLY)
        self.wait_for(f"part/frame_{frame:06}.hdf", process)
        process.send_signal(number)
        output, errors = process.communicate(timeout=120)
        return process.returncode, output, errors

    def go_on(self, errors):
        """Types what the interrupted run says."""
        command = re.search(r"^to go on: (salvo .*)$", errors, re.MULTILINE)
        self.assertTrue(command, errors)
        return self.salvo(*shlex.split(command[1])[1:])

    def test_ctrl_c_and_going_on_give_the_files_of_an_uninterrupted_run(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            with self.subTest(number):
                status, output, errors = self.interrupted(7, number)
                self.assertEqual(status, 130, errors)
                step = int(re.search(r"salvo: interrupted at step (\d+) of 2000; what is recorded is complete",
                                     errors)[1])
                self.assertGreaterEqual(step, 140)
                self.assertLess(step, 2000)
                self.assertIn(f"at step {step}\n", output)
                report = json.loads((self.dir / "part/run.json").read_text())
                self.assertEqual(report["status"], "interrupted")
                whole = self.recording("whole")
                for name, content in self.recording("part").items():  # complete, and nothing else than was asked for
                    if name.startswith("frame_"):
                        self.assertEqual(content, whole[name], name)
                self.salvo("export", "part", "--format", "csv", "--frame", "7", "-o", "text")
                resumed = self.go_on(errors)
                self.assertIn(f"going on from step {step} of 2000", resumed.stderr)
                self.assert_same_recording("part", "whole")
                subprocess.run(["rm", "-r", self.dir / "part"], check=True)

    def test_twice_interrupted_and_then_resumed_when_done(self):
        _, _, errors = self.interrupted(3)
        process = self.start("run", "long.toml", "--out", "part", "--resume", *SLOWLY)
        self.wait_for("part/frame_000040.hdf", process)
        process.send_signal(signal.SIGINT)
        errors = process.communicate(timeout=120)[1]
        self.assertEqual(process.returncode, 130, errors)
        self.go_on(errors)
        self.assert_same_recording("part", "whole")
        again = self.salvo("run", "long.toml", "--out", "part", "--resume")  # there is nothing left to do
        self.assertIn("going on from step 2000 of 2000", again.stderr)
        self.assert_same_recording("part", "whole")

    def test_ctrl_c_between_two_frames_and_a_second_one(self):
        process = self.start("run", "long.toml", "--out", "part", *SLOWLY, "--set", "frames.every=2000")
        self.wait_for("part/frame_000000.hdf", process)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130)
        step = int(re.search(r"interrupted at step (\d+) of 2000", errors)[1])
        self.assertLess(step, 2000)
        process = self.start("run", "long.toml", "--out", "part", "--resume", *SLOWLY, "--set", "frames.every=2000")
        self.assertIn(f"going on from step {step} of 2000", process.stderr.readline())
        process.send_signal(signal.SIGINT)
        while "once more to stop at once" not in process.stderr.readline():
            pass
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130)
        self.salvo("run", "long.toml", "--out", "part", "--resume", "--set", "frames.every=2000")
        self.salvo("run", "long.toml", "--out", "other", "--set", "frames.every=2000")
        self.assert_same_recording("part", "other")

    def test_kill_and_going_on(self):
        for every, frame in ((0, 5), (130, 11), (20, 0)):
            with self.subTest(every=every):
                changes = ["--set", f"checkpoint.every={every}"] if every else []
                process = self.start("run", "long.toml", "--out", "part", *SLOWLY, *changes)
                self.wait_for(f"part/frame_{frame:06}.hdf", process)
                process.kill()
                process.communicate()
                self.salvo("run", "long.toml", "--out", "part", "--resume", *changes)
                self.salvo("run", "long.toml", "--out", "other", *changes)
                self.assert_same_recording("part", "other")
                subprocess.run(["rm", "-r", self.dir / "part", self.dir / "other"], check=True)

    def test_a_damaged_checkpoint_is_passed_over(self):
        changes = ["--set", "checkpoint.every=100"]
        status, _, _ = self.interrupted(9)
        self.assertEqual(status, 130)
        checkpoint = next((self.dir / "part").glob("checkpoint_*.hdf"))
        content = bytearray(checkpoint.read_bytes())
        content[len(content) // 2] ^= 1
        checkpoint.write_bytes(content)
        resumed = self.salvo("run", "long.toml", "--out", "part", "--resume")
        self.assertIn(checkpoint.name, resumed.stderr)
        self.assert_same_recording("part", "whole")
        self.salvo("run", "long.toml", "--out", "part", "--resume", *changes, status=4)  # another scene


class Verify(Case):
    def test_the_same_bits(self):
        result = self.salvo("verify", "scene.toml")
        isas = self.document("info")["isas"]
        rows = [line.split()[0] for line in result.stdout.splitlines() if line.endswith(("equal", "particles"))]
        self.assertEqual(rows, ["isa"] * (len(isas) - 1) + ["threads"] * 5 + ["pass"] * 2 +
                         ["resume", "rows", "emitter"])
        self.assertIn(f"the same bits in {len(rows) + 1} runs", result.stdout)
        final = self.document("hash", "scene.toml")["state_hash"]
        self.assertEqual(result.stdout.count(final), len(rows) - 1)

    def test_chosen_axes_and_json(self):
        document = self.document("verify", "scene.toml", "--isa", "scalar", "--threads", "13,2", "--threads", "5",
                                 "--pass", "9")
        runs = document["scenes"][0]["runs"]
        self.assertEqual([(run["axis"], run["value"]) for run in runs[1:5]],
                         [("threads", "13"), ("threads", "2"), ("threads", "5"), ("pass", "9")])
        self.assertTrue(document["equal"])
        self.assertTrue(all(run["equal"] for run in runs))

    def test_the_scenes_verify_size_and_its_own(self):
        small = ["--set", "verify.rows=300", "--set", "verify.steps=40", "--isa", "scalar", "--threads", "2", "--pass",
                 "3"]
        document = self.document("verify", "scene.toml", *small)["scenes"][0]
        self.assertLessEqual(document["particles"], 300)
        self.assertEqual(document["steps"], 40)
        document = self.document("verify", "scene.toml", *small, "--full")["scenes"][0]
        self.assertEqual((document["particles"], document["steps"]), (1501, 200))

    def test_several_scenes(self):
        self.write("other.toml", SCENE.replace("seed = 5", "seed = 6"))
        result = self.salvo("verify", "scene.toml", "other.toml", "--isa", "scalar", "--threads", "2", "--pass", "3")
        self.assertEqual(result.stdout.count("the same bits in"), 2)


    def test_a_bad_scene_among_good_ones(self):
        few = ["--isa", "scalar", "--threads", "2", "--pass", "3"]
        self.write("bad.toml", SCENE.replace("speed = 3", "sped = 3"))
        result = self.salvo("verify", "scene.toml", "bad.toml", "none.toml", "scene.toml", *few, status=4)
        self.assertEqual(result.stdout.count("the same bits in"), 2)
        self.assertIn('did you mean "speed"?', result.stderr)
        self.assertIn("cannot read none.toml", result.stderr)
        document = self.document("verify", "scene.toml", "bad.toml", "scene.toml", *few, status=3)
        self.assertEqual([scene.get("equal") for scene in document["scenes"]], [True, None, True])
        self.assertEqual(len(document["scenes"][1]["mistakes"]), 1)
        self.assertFalse(document["equal"])


class Exports(Case):
    def setUp(self):
        super().setUp()
        self.salvo("run", "scene.toml")

    def test_csv(self):
        text = self.salvo("export", "out/scene", "--format", "csv", "--frame", "3", "-o", "-").stdout
        header, *rows = text.splitlines()
        self.assertTrue(header.startswith("id,position_x"))
        frame = self.document("hash", "scene.toml")["frames"][3]
        self.assertEqual(frame["step"], 60)
        self.assertGreater(len(rows), 1000)
        ids = [int(row.split(",")[0]) for row in rows]
        self.assertEqual(ids, sorted(ids))
        self.salvo("export", "out/scene", "--format", "csv")
        written = sorted((self.dir / "out/scene/csv").iterdir())
        self.assertEqual(len(written), 11)
        self.assertEqual(written[3].read_text(), text)

    def test_npy_and_ply(self):
        document = self.document("export", "out/scene", "--format", "npy", "--columns", "id,position", "-o", "arrays")
        self.assertEqual(len(document["files"]), 22)
        for file in document["files"]:
            self.assertEqual((self.dir / file).read_bytes()[:6], b"\x93NUMPY")
        self.salvo("export", "out/scene/frame_000002.hdf", "--format", "ply", "-o", "points")
        (file,) = (self.dir / "points").iterdir()
        self.assertTrue(file.read_bytes().startswith(b"ply\nformat binary_little_endian 1.0\n"))

    def test_mistakes(self):
        def problem(*arguments, status=2):
            return self.salvo("export", *arguments, status=status).stderr
        self.assertIn('did you mean "csv"?', problem("out/scene", "--format", "cvs"))
        self.assertIn("needs a --format", problem("out/scene"))
        self.assertIn("its frames go from 0 to 10", problem("out/scene", "--format", "csv", "--frame", "11"))
        self.assertIn("mass", problem("out/scene", "--format", "csv", "--columns", "mass"))
        self.assertIn("name it: --frame 0", problem("out/scene", "--format", "csv", "-o", "-"))
        self.assertIn("no such recording", problem("out/none", "--format", "csv", status=4))
        self.assertIn("holds no frames", problem("out", "--format", "csv", status=4))
        frame = self.dir / "out/scene/frame_000004.hdf"
        frame.write_bytes(frame.read_bytes()[:-100])
        self.assertIn("frame_000004.hdf", problem("out/scene", "--format", "csv", "--frame", "4", "-o", "-", status=4))


class Terminal(Case):
    def on_terminal(self, *arguments, **variables):
        """What the command shows on a terminal (stderr), and its exit status."""
        try:
            master, slave = pty.openpty()
        except OSError as error:  # a bare root without /dev/pts
            self.skipTest(f"no pseudo-terminal: {error}")
        process = subprocess.Popen([SALVO, *arguments], cwd=self.dir, stdout=subprocess.DEVNULL, stderr=slave,
                                   env={**self.environment, "TERM": "xterm", **variables})
        os.close(slave)
        shown = b""
        try:
            while chunk := os.read(master, 4096):
                shown += chunk
        except OSError:  # the other end is closed
            pass
        os.close(master)
        return shown.decode(), process.wait()

    def test_progress_is_redrawn_on_a_terminal(self):
        self.write("long.toml", LONG)
        shown, status = self.on_terminal("run", "long.toml", *SLOWLY)
        self.assertEqual(status, 0)
        lines = re.findall(r"\r *(\d+) %  frame \d+ of 101  [\d.]+ [kMG]? ?particle-steps/s  [\d.]+ [kMG]?B written  "
                           r"[^\r]* left\x1b\[K", shown)
        self.assertGreater(len(lines), 1, shown)
        self.assertEqual([int(line) for line in lines], sorted(int(line) for line in lines))
        shown, _ = self.on_terminal("hash", "long.toml", "-q", *SLOWLY)
        self.assertEqual(shown, "")

    def test_colour_only_where_it_is_wanted(self):
        self.assertIn("\x1b[1;31merror:\x1b[0m", self.on_terminal("rnu")[0])
        for variables in ({"NO_COLOR": "1"}, {"TERM": "dumb"}):
            self.assertNotIn("\x1b", self.on_terminal("rnu", **variables)[0])
        self.assertNotIn("\x1b", self.salvo("rnu", status=2).stderr)


if __name__ == "__main__":
    SALVO = os.path.abspath(sys.argv.pop(1))
    unittest.main()
