#!/usr/bin/python3
"""HDF5 between sweeps and other programs: what h5py writes becomes the inputs of a sweep.

usage: sweep_hdf5_test.py SALVO [unittest arguments]
"""
import os
import sys
import unittest

import cli_test
from cli_test import Case

import h5py
import numpy

FROM_TABLE = """\
[shot_in_air]
speed = { column = "load/speed" }
elevation = { column = "elevation" }
drag_factor = 1e-3
ground = 0
[sweep]
table = "inputs.h5"
[integration]
step = 0.1
absolute_tolerance = 1e-5
time_limit = 100
"""


class Inputs(Case):
    def setUp(self):
        super().setUp()
        self.write("shots.toml", FROM_TABLE)
        self.speeds = numpy.linspace(600, 2900, 1000)
        self.put(self.speeds)

    def put(self, speeds):
        with h5py.File(self.dir / "inputs.h5", "w") as file:
            # As large tables are written: in blocks, compressed, in single precision.
            speed = file.create_dataset("load/speed", data=speeds, compression="gzip", chunks=(128,))
            speed.attrs["units"] = "fps"
            file.create_dataset("elevation", data=numpy.linspace(0.1, 0.5, len(speeds), dtype="float32"))

    def rows(self, folder):
        with h5py.File(self.dir / folder / "trajectories.hdf") as file:
            return {name: file[name][:] for name in ("input/speed", "input/elevation", "end/x")}

    def test_a_file_of_h5py_gives_the_rows_of_its_csv_file(self):
        self.assertEqual(self.document("run", "shots.toml", "--out", "a")["rows"], 1000)
        lines = [f"{speed!r},{float(elevation)!r}" for speed, elevation in
                 zip(self.speeds.tolist(), numpy.linspace(0.1, 0.5, 1000, dtype="float32"))]
        self.write("inputs.csv", "\n".join(["load/speed [fps],elevation [rad]", *lines]) + "\n")
        self.salvo("run", "shots.toml", "--out", "b", "--set", "sweep.table=inputs.csv")
        of_hdf5, of_csv = self.rows("a"), self.rows("b")
        for name, values in of_hdf5.items():
            self.assertTrue(numpy.array_equal(values, of_csv[name]), name)
        self.assertTrue(numpy.allclose(of_hdf5["input/speed"], self.speeds * 0.3048, rtol=1e-15, atol=0))

    def test_rows_of_a_sweep_are_the_inputs_of_the_next(self):
        self.salvo("run", "shots.toml", "--out", "first")
        self.salvo("run", "shots.toml", "--out", "second", "--set", "sweep.table=first/trajectories.hdf",
                   "--set", 'shot_in_air.speed={ column = "end/speed" }',
                   "--set", 'shot_in_air.elevation={ column = "input/elevation" }')
        with h5py.File(self.dir / "first/trajectories.hdf") as file:
            self.assertTrue(numpy.array_equal(file["end/speed"][:], self.rows("second")["input/speed"]))

    def test_other_numbers_are_another_scene(self):
        self.salvo("run", "shots.toml", "--out", "there")
        self.salvo("run", "shots.toml", "--out", "there", "--resume")
        self.put(numpy.nextafter(self.speeds, 0))
        result = self.salvo("run", "shots.toml", "--out", "there", "--resume", status=4)
        self.assertIn("--force replaces what is there", result.stderr)

    def test_a_mistake_is_one_message_with_its_remedy(self):
        result = self.salvo("validate", "shots.toml", "--set", 'shot_in_air.speed={ column = "load/sped" }', status=3)
        self.assertIn('inputs.h5 has no dataset "load/sped"', result.stderr)
        self.assertIn('did you mean "load/speed"?', result.stderr)
        self.put(numpy.append(self.speeds, numpy.nan))
        result = self.salvo("validate", "shots.toml", status=3)
        self.assertIn('inputs.h5: dataset "load/speed" is nan in row 1001', result.stderr)
        (self.dir / "inputs.h5").unlink()
        self.assertIn("No such file", self.salvo("validate", "shots.toml", status=3).stderr)


if __name__ == "__main__":
    cli_test.SALVO = os.path.abspath(sys.argv.pop(1))
    unittest.main()
