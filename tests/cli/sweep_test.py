#!/usr/bin/python3
"""Scenes of trajectories as a user meets them: rows, files, one row alone, shards, resuming, extending, messages.

usage: sweep_test.py SALVO [unittest arguments]
"""
import csv
import io
import json
import math
import os
import resource
import signal
import sys
import unittest

import cli_test
from cli_test import Case

try:
    import h5py
    import numpy
except ImportError:
    h5py = None

# Three parts, the last not full; an event on the way, samples, and rows that end in two ways.
SCENE = """\
title = "a test"
seed = 5
[shot_in_air]
speed = { normal = [300, 5] }
elevation = { uniform = [0.05, 0.7] }
drag_factor = 1e-3
wind_z = { normal = [0, 3], within = [-8, 8] }
ground = 0
range = 800
[sweep]
samples = 140_000
[integration]
step = 0.1
absolute_tolerance = 1e-5
relative_tolerance = 1e-6
time_limit = 100
record = ["apex"]
[samples]
levels = [1, 5]
[statistics]
columns = ["end.z", "time"]
outcomes = ["ground", "range"]
[statistics.plane]
axes = ["end.x", "end.z"]
half_sizes = [500, 10]
"""
FEW = ["--set", "sweep.samples=500"]


class Sweep(Case):
    def setUp(self):
        super().setUp()
        self.write("sweep.toml", SCENE)

    def csv_rows(self, *arguments):
        text = self.salvo("export", *arguments, "--format", "csv", "-o", "-").stdout
        return list(csv.DictReader(io.StringIO(text)))

    def test_a_run_tells_outcomes_statistics_and_one_hash(self):
        text = self.salvo("run", "sweep.toml").stdout
        for words in ("ground", "range", "end.z m", "circular error about the mean", "hits", "of 140,000 rows",
                      "trajectories in"):
            self.assertIn(words, text)
        told = json.loads((self.dir / "out/sweep/statistics.json").read_text())
        self.assertEqual(told["rows"], 140_000)
        self.assertEqual(sum(told["outcomes"].values()), 140_000)
        self.assertEqual(told["counted"], told["outcomes"]["ground"] + told["outcomes"]["range"])
        run = json.loads((self.dir / "out/sweep/run.json").read_text())
        self.assertEqual(run["status"], "done")
        self.assertIn(run["sweep"]["hash"], text)
        self.assertIn(run["sweep"]["hash"], self.salvo("hash", "sweep.toml", "--isa", "scalar").stdout)

    def test_statistics_are_those_of_the_exported_rows(self):
        document = self.document("run", "sweep.toml", *FEW)
        rows = [row for row in self.csv_rows("out/sweep") if row["outcome"] in ("ground", "range")]
        drift = sorted(float(row["end.z [m]"]) for row in rows)
        column = document["statistics"]["columns"][0]
        mean = math.fsum(drift) / len(drift)
        self.assertAlmostEqual(column["mean"], mean, 12)
        deviation = math.sqrt(math.fsum((x - mean) ** 2 for x in drift) / (len(drift) - 1))
        self.assertAlmostEqual(column["deviation"], deviation, 10)
        place = 0.95 * (len(drift) - 1)
        low = drift[int(place)]
        self.assertAlmostEqual(column["quantiles"][2]["value"],
                               low + (drift[int(place) + 1] - low) * (place - int(place)), 12)
        hits = sum(abs(float(row["end.x [m]"])) <= 500 and abs(float(row["end.z [m]"])) <= 10 for row in rows)
        self.assertEqual(document["statistics"]["plane"]["hits"]["count"], hits)

    def test_one_row_alone_is_the_row_among_the_others(self):
        self.salvo("run", "sweep.toml")
        rows = self.csv_rows("out/sweep", "--columns", "id,input.speed,end.x,apex.y,outcome")
        for index in (0, 65_535, 65_536, 139_999):
            alone = self.document("run", "sweep.toml", "--index", index, "--isa", "sse2")["trajectories"][0]
            self.assertEqual(int(rows[index]["id"]), index)
            self.assertEqual(float(rows[index]["end.x [m]"]), alone["end.x"])
            apex = alone["apex.y"]
            self.assertEqual(rows[index]["apex.y [m]"], "nan" if apex is None else repr(apex))
            self.assertEqual(rows[index]["outcome"], alone["outcome"])
        result = self.salvo("run", "sweep.toml", "--index", 140_000, status=2)
        self.assertIn("the rows go from 0 to 139999", result.stderr)

    def test_shards_merge_to_the_files_of_one_run(self):
        self.salvo("run", "sweep.toml", "--out", "whole")
        for shard in (1, 2, 3):
            self.salvo("run", "sweep.toml", "--shard", f"{shard}/3", "--threads", shard, "--out", f"s{shard}")
        merged = self.document("merge", "s3", "s1", "s2", "--out", "merged")
        self.assert_same_recording("whole", "merged")
        whole = json.loads((self.dir / "whole/run.json").read_text())
        self.assertEqual(merged["hash"], whole["sweep"]["hash"])
        result = self.salvo("merge", "s1", "s3", "--out", "holes", status=4)
        self.assertIn("rows 65536 to 131071 are in none of the folders", result.stderr)
        self.salvo("run", "sweep.toml", "--set", "seed=6", "--shard", "2/3", "--out", "other")
        result = self.salvo("merge", "s1", "other", "--out", "mixed", status=4)
        self.assertIn("is of another scene", result.stderr)

    def test_a_killed_run_goes_on_to_the_same_files(self):
        slowly = ["--isa", "scalar", "--threads", "1"]
        process = self.start("run", "sweep.toml", *slowly, "--out", "killed")
        self.wait_for("killed/rows_000000.hdf", process)
        process.kill()
        process.communicate()
        document = self.document("run", "sweep.toml", "--out", "killed", "--resume", "--threads", 13)
        self.assertGreaterEqual(document["kept"], 65_536)
        self.salvo("run", "sweep.toml", "--out", "whole")
        self.assert_same_recording("killed", "whole")

    def test_ctrl_c_finishes_the_part_and_says_how_to_go_on(self):
        process = self.start("run", "sweep.toml", "--isa", "scalar", "--threads", "1")
        self.wait_for("out/sweep/run.json", process)
        process.send_signal(signal.SIGINT)
        _, said = process.communicate()
        self.assertEqual(process.returncode, 130, said)
        self.assertIn("--resume", said)
        run = json.loads((self.dir / "out/sweep/run.json").read_text())
        self.assertEqual(run["status"], "interrupted")
        self.salvo("run", "sweep.toml", "--resume")
        self.salvo("run", "sweep.toml", "--out", "whole")
        self.assert_same_recording("out/sweep", "whole")

    def test_an_extended_sweep_keeps_its_first_rows(self):
        self.salvo("run", "sweep.toml", "--set", "sweep.samples=70_000", "--out", "grown")
        document = self.document("run", "sweep.toml", "--out", "grown", "--resume")
        self.assertEqual(document["kept"], 65_536)
        whole = self.document("run", "sweep.toml", "--out", "whole")
        self.assertEqual(document["hash"], whole["hash"])

    def test_an_altered_part_is_computed_again(self):
        self.salvo("run", "sweep.toml", "--out", "whole")
        self.salvo("run", "sweep.toml")
        part = self.dir / "out/sweep/rows_000001.hdf"
        content = bytearray(part.read_bytes())
        content[len(content) // 2] ^= 1
        part.write_bytes(content)
        self.assertEqual(self.document("run", "sweep.toml", "--resume")["kept"], 65_536 + 140_000 - 131_072)
        self.assert_same_recording("out/sweep", "whole")

    def test_a_full_disk_keeps_what_is_there(self):
        # Stands in for one: no file may grow beyond this, once the first is there. Python's children inherit that SIGXFSZ
        # is ignored.
        process = self.start("run", "sweep.toml", "--isa", "scalar", "--threads", "1", "--json", restore_signals=False)
        self.wait_for("out/sweep/rows_000000.hdf", process)
        resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (2_000_000, 2_000_000))
        told, said = process.communicate()
        self.assertEqual(process.returncode, 4, said)
        self.assertIn("cannot write", said)
        self.assertIn("65,536 rows in out/sweep", said)
        self.assertIn("--resume", said)
        document = json.loads(told)
        self.assertEqual((document["status"], document["exit_status"], document["rows"]), ("failed", 4, 65_536))
        self.assertIn("cannot write out/sweep/rows_000001.hdf", document["error"]["message"])
        self.assertEqual(json.loads((self.dir / "out/sweep/run.json").read_text())["status"], "failed")
        self.assertEqual(self.document("run", "sweep.toml", "--resume")["kept"], 65_536)
        self.salvo("run", "sweep.toml", "--out", "whole")
        self.assert_same_recording("out/sweep", "whole")

    def test_missing_rows_are_told(self):
        self.salvo("run", "sweep.toml")
        self.salvo("run", "sweep.toml", "--shard", "2/3", "--out", "shard")
        self.assertEqual(len(self.csv_rows("shard", "--columns", "id")), 65_536)
        for part, problem in ((1, "rows 65536 to 131071 are missing in out/sweep"),
                              (2, "out/sweep holds 131072 of the 140000 rows that run.json tells of")):
            path = self.dir / f"out/sweep/rows_{part:06}.hdf"
            path.rename(self.dir / "away.hdf")
            self.assertIn(problem, self.salvo("export", "out/sweep", "--format", "csv", status=4).stderr)
            self.assertFalse((self.dir / "out/sweep/csv/trajectories.csv").exists())
            if h5py and part == 1:
                with h5py.File(self.dir / "out/sweep/trajectories.hdf") as file:
                    self.assertTrue(numpy.all(numpy.isnan(file["end/x"][65_536:131_072])))
                    self.assertTrue(numpy.all(numpy.isnan(file["samples/x"][65_536:131_072])))
                    self.assertEqual(file["id"][65_536], 2**64 - 1)
                    self.assertEqual(file["outcome"][65_536], 2**32 - 1)
                    self.assertEqual(file["id"][131_072], 131_072)
            (self.dir / "away.hdf").rename(path)
        self.salvo("run", "sweep.toml", "--set", "seed=6", "--shard", "2/3", "--out", "other")
        (self.dir / "other/rows_000001.hdf").replace(self.dir / "out/sweep/rows_000001.hdf")
        self.assertIn("rows_000001.hdf is of another scene", 
                      self.salvo("export", "out/sweep", "--format", "csv", status=4).stderr)

    def test_a_run_keeps_the_rows_of_others(self):
        self.salvo("run", "sweep.toml", "--out", "whole")
        for again in ([], ["--resume"]):
            for shard in ("2/2", "1/2"):
                self.salvo("run", "sweep.toml", "--shard", shard, "--out", "shared", *again)
            document = self.document("run", "sweep.toml", "--out", "shared", "--resume")
            self.assertEqual(document["kept"], 140_000)
            self.assert_same_recording("shared", "whole")
        for fewer in ("1000", "65_536", "139_999"):
            result = self.salvo("run", "sweep.toml", "--set", f"sweep.samples={fewer}", "--out", "shared", "--resume",
                                status=4)
            self.assertIn("shared holds rows of this sweep up to row 139999, more than the", result.stderr)
            self.assertIn("--force replaces what is there", result.stderr)
        self.assert_same_recording("shared", "whole")
        self.salvo("run", "sweep.toml", "--set", "sweep.samples=66_000", "--out", "shared", "--force")
        self.assertFalse((self.dir / "shared/rows_000002.hdf").exists())
        # Also a shard replaces all of another scene's rows, so that none are left among its own.
        self.salvo("run", "sweep.toml", "--set", "seed=6", "--shard", "1/2", "--out", "shared", "--force")
        self.assertFalse((self.dir / "shared/rows_000001.hdf").exists())

    def test_a_merge_that_cannot_be_says_why(self):
        self.write("columns.csv", "speed\n" + "300\n" * 70_000)
        self.write("table.toml", SCENE.replace("{ normal = [300, 5] }", '{ column = "speed" }')
                   .replace("samples = 140_000", 'table = "columns.csv"'))
        for shard in (1, 2):
            self.salvo("run", "table.toml", "--shard", f"{shard}/2", "--out", f"t{shard}")
        self.write("columns.csv", "speed\n" + "301\n" * 70_000)
        result = self.salvo("merge", "t1", "t2", "--out", "merged", status=4)
        self.assertIn("most likely a table that the scene reads has changed", result.stderr)
        self.assertFalse((self.dir / "merged").exists())
        self.assertIn("cannot read nowhere: No such file", self.salvo("merge", "t1", "nowhere", "-o", "m", status=4).stderr)
        self.assertIn("table.toml is not a folder", self.salvo("merge", "table.toml", "-o", "m", status=4).stderr)

        self.salvo("run", "sweep.toml", "--out", "long")
        self.salvo("run", "sweep.toml", "--set", "sweep.samples=70_000", "--out", "short")
        for inputs in (["long", "short"], ["short", "long"]):
            result = self.salvo("merge", *inputs, "--out", "m", status=4)
            self.assertIn("the shards have different numbers of samples", result.stderr)
        (self.dir / "long/rows_000001.hdf").unlink()
        (self.dir / "short/rows_000000.hdf").unlink()
        result = self.salvo("merge", "long", "short", "--out", "m", status=4)
        self.assertIn("run the shards with one number of samples", result.stderr)

        self.write("stop.toml", SCENE + '[stop]\ncolumn = "time"\nhalf_width = "20 ms"\n')
        self.salvo("run", "stop.toml", "--out", "stopped")
        self.assertIn("[stop] ended the sweep", self.salvo("merge", "stopped", "--out", "m", status=4).stderr)
        self.assertFalse((self.dir / "m").exists())

    def test_a_merge_replaces_only_when_forced_and_then_all(self):
        self.salvo("run", "sweep.toml", "--set", "sweep.samples=70_000", "--out", "short")
        self.salvo("run", "sweep.toml", "--set", "seed=6", "--out", "target")
        before = self.recording("target")
        result = self.salvo("merge", "short", "--out", "target", status=4)
        self.assertIn("--force replaces what is there", result.stderr)
        self.assertTrue(self.recording("target") == before)
        self.salvo("merge", "short", "--out", "target", "--force")
        self.assert_same_recording("target", "short")
        self.salvo("merge", "short", "--out", "short", "--force")
        self.assert_same_recording("target", "short")
        self.salvo("run", "sweep.toml", "--out", "target", "--resume")
        result = self.salvo("merge", "short", "--out", "target", status=4)
        self.assertIn("target holds rows of this sweep up to row 139999", result.stderr)
        self.salvo("run", "sweep.toml", "--out", "target", "--resume")
        # The parts of an extended sweep are from before and after.
        self.assertEqual(self.document("merge", "target", "--out", "copy")["rows"], 140_000)

    def test_another_scenes_recording_is_not_replaced_unasked(self):
        self.salvo("run", "sweep.toml", *FEW, "--out", "there")
        for scene in (["sweep.toml", "--set", "seed=6"], ["scene.toml"]):
            result = self.salvo("run", *scene, "--out", "there", status=4)
            self.assertIn("--force replaces what is there", result.stderr)
        self.salvo("run", "sweep.toml", *FEW, "--set", "seed=6", "--out", "there", "--force")

    def test_a_sweep_stops_when_the_mean_is_known(self):
        stop = '[stop]\ncolumn = "time"\nhalf_width = "20 ms"\n'
        self.write("stop.toml", SCENE + stop)
        document = self.document("run", "stop.toml")
        self.assertEqual(document["rows"], 65_536)
        self.assertTrue(document["stop"]["reached"])
        never = self.document("run", "stop.toml", "--set", "stop.half_width=1e-9", "--out", "never")
        self.assertEqual(never["rows"], 140_000)
        self.assertFalse(never["stop"]["reached"])
        self.salvo("run", "stop.toml", "--shard", "1/2", status=2)
        for width in ("0.02", "1e-9"):
            run = self.document("run", "stop.toml", "--set", f"stop.half_width={width}", "--out", f"width{width}")
            hashed = self.document("hash", "stop.toml", "--set", f"stop.half_width={width}")
            self.assertEqual((hashed["state_hash"], hashed["stop"]), (run["hash"], run["stop"]))
        self.assertIn("65536 rows, where [stop] ends the sweep", self.salvo("hash", "stop.toml").stdout)
        # Rows that are there are not given up for the sake of a [stop].
        result = self.salvo("run", "stop.toml", "--out", "never", "--resume", status=4)
        self.assertIn("never holds rows of this sweep up to row 139999", result.stderr)
        self.assertEqual(self.document("run", "stop.toml", "--out", "never", "--force")["rows"], 65_536)

    def test_verify_info_validate(self):
        runs = self.document("verify", "sweep.toml", "--set", "verify.rows=5000")["scenes"][0]
        self.assertTrue(runs["equal"])
        self.assertEqual(runs["rows"], 5000)
        self.assertIn("140,000 trajectories", self.salvo("validate", "sweep.toml").stdout)
        info = self.document("info", "sweep.toml")
        self.assertEqual(info["varied"], ["speed", "elevation", "wind_z"])
        self.assertIn("speed, elevation, wind_z", self.salvo("info", "sweep.toml").stdout)
        self.assertIn("[integration]", self.salvo("info", "--keys").stdout)

    def test_a_few_rows_are_printed_themselves(self):
        text = self.salvo("run", "sweep.toml", "--set", "sweep.samples=2").stdout
        self.assertIn("row 0", text)
        self.assertIn("row 1", text)
        self.assertIn("samples of row 0", text)
        two = ["--set", "sweep.samples=2"]
        again = self.salvo("run", "sweep.toml", *two, "--resume").stdout
        self.assertEqual(again.partition("hash")[0], text.partition("hash")[0])
        self.assertIn("\n2 rows were there\n", again)
        document = self.document("run", "sweep.toml", *two, "--resume")
        fresh = self.document("run", "sweep.toml", *two, "--out", "fresh")
        self.assertEqual(document["trajectories"], fresh["trajectories"])
        one = ["--set", "sweep.samples=1", "--set", "samples.levels=" + str(list(range(1, 251))), "--out", "one"]
        self.assertIn("\n... 50 more\n", self.salvo("run", "sweep.toml", *one).stdout)
        self.assertIn("\n1 row was there\n", self.salvo("run", "sweep.toml", *one, "--resume").stdout)

    def test_what_does_not_fit_in_memory_is_refused(self):
        self.write("many.toml", SCENE.replace("levels = [1, 5]", "from = 0\nto = 90\nevery = 1e-3"))
        for verb in ("run", "hash", "verify"):
            result = self.salvo(verb, "many.toml", status=1)
            self.assertRegex(result.stderr, r"many.toml takes .* TB of memory, and .* are available")
        self.assertFalse((self.dir / "out").exists())

    def test_rows_that_diverge_are_outcomes(self):
        self.write("bad.toml", "[lorenz]\nx = 1e8\nsigma = { uniform = [1e7, 1e8] }\n[sweep]\nsamples = 100\n"
                               "[integration]\nmethod = \"runge_kutta_4\"\nstep = 0.01\ntime_limit = 1\n")
        document = self.document("run", "bad.toml")
        self.assertEqual(document["statistics"]["outcomes"]["not finite"], 100)
        self.assertEqual(document["statistics"]["counted"], 0)
        self.assertIn("no row counts", self.salvo("run", "bad.toml").stdout)

    def test_options_of_other_scenes_are_refused(self):
        for arguments in (["--index", "1"], ["--shard", "1/2"]):
            self.assertIn("scenes of trajectories", self.salvo("run", "scene.toml", *arguments, status=2).stderr)
        for arguments in (["--shard", "3"], ["--shard", "3/2"], ["--shard", "1/4"], ["--index", "1", "--resume"]):
            self.salvo("run", "sweep.toml", *arguments, status=2)
        self.salvo("merge", "out", status=2)
        self.salvo("export", "out", "--format", "npy", status=4)

    @unittest.skipUnless(h5py, "h5py is not installed")
    def test_hdf5_holds_what_csv_holds(self):
        self.salvo("run", "sweep.toml")
        rows = self.csv_rows("out/sweep")
        with h5py.File(self.dir / "out/sweep/trajectories.hdf") as file:
            outcomes = [name.decode() for name in file["salvo"].attrs["outcomes"]]
            self.assertEqual(len(file["id"]), 140_000)
            for title in rows[0]:
                name, _, unit = title.partition(" [")
                dataset = file[name.replace(".", "/")]
                self.assertEqual(dataset.attrs["units"].decode() if dataset.attrs["units"] else "", unit.rstrip("]"))
                self.assertTrue(dataset.attrs["meaning"])
                values = dataset[:]
                for index in (0, 1, 65_535, 65_536, 131_072, 139_999):
                    text = rows[index][title]
                    if name == "outcome":
                        self.assertEqual(outcomes[values[index]], text)
                    else:
                        self.assertEqual(str(float(text)), str(float(values[index])), title)
            self.assertEqual(file["samples/x"].shape, (140_000, 2))
            self.assertTrue(numpy.all(file["samples/time"][:, 0] == 1))


if __name__ == "__main__":
    cli_test.SALVO = os.path.abspath(sys.argv.pop(1))
    unittest.main()
