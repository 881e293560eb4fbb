#!/usr/bin/python3
"""HDF5 between sweeps and other programs: what h5py writes becomes the inputs of a sweep, and what a sweep writes opens
in pandas and xarray.

usage: sweep_hdf5_test.py SALVO [unittest arguments]
"""
import os
import sys
import unittest

import h5py
import numpy
import pandas
import xarray

import cli_test
from cli_test import Case
from sweep_test import SCENE

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


class Outputs(Case):
    """The files are those of netCDF-4 to xarray, whichever of its two readers it has."""

    ROWS = 70_000  # two parts, the last not full

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        # One sweep for all tests; the methods of a case need an instance.
        cls.case = case = Case()
        case.setUp()
        cls.addClassCleanup(case.doCleanups)
        case.write("sweep.toml", SCENE)
        case.salvo("run", "sweep.toml", "--set", f"sweep.samples={cls.ROWS}")
        case.salvo("export", "out/sweep", "--format", "csv")
        cls.out = case.dir / "out/sweep"
        # pandas' usual reading of numbers is off by a bit here and there.
        cls.csv = pandas.read_csv(cls.out / "csv/trajectories.csv", index_col="id", float_precision="round_trip")
        cls.csv.columns = [title.partition(" [")[0] for title in cls.csv.columns]

    def opened(self, name, group=None, engine=None):
        file = xarray.open_dataset(self.out / name, group=group, engine=engine)
        self.addCleanup(file.close)
        return file

    def check_columns(self, name, engine, ids):
        rows = self.csv.loc[ids]
        root = self.opened(name, engine=engine)
        self.assertEqual(dict(root.sizes), {"id": len(ids)})
        self.assertTrue(numpy.array_equal(root.indexes["id"], ids))
        outcomes = numpy.array(self.opened(name, "salvo", engine).attrs["outcomes"])
        seen = {"id"}
        for group in (None, "input", "end", "apex"):
            file = self.opened(name, group, engine)
            table = file.to_dataframe()
            for column in table.columns:
                full = f"{group}.{column}" if group else column
                self.assertEqual(file[column].dims, ("id",))
                values = outcomes[table[column]] if full == "outcome" else table[column].to_numpy()
                numpy.testing.assert_array_equal(values, rows[full].to_numpy(), full)
                seen.add(full)
        self.assertEqual(seen, {"id", *self.csv.columns})

    def test_columns_are_those_of_the_csv_file(self):
        self.assertEqual(len(self.csv), self.ROWS)
        self.assertTrue(self.csv["apex.y"].isna().any())  # rows that end on their way up
        for engine in ("netcdf4", "h5netcdf"):
            for name, first, last in (("trajectories.hdf", 0, self.ROWS), ("rows_000000.hdf", 0, 65_536),
                                      ("rows_000001.hdf", 65_536, self.ROWS)):
                with self.subTest(f"{name} by {engine}"):
                    self.check_columns(name, engine, numpy.arange(first, last))

    def test_samples_are_over_rows_and_levels(self):
        alone = self.case.document("run", "sweep.toml", "--index", 1)["trajectories"][0]["samples"]
        for engine in ("netcdf4", "h5netcdf"):
            for name, rows in (("trajectories.hdf", self.ROWS), ("rows_000000.hdf", 65_536)):
                with self.subTest(f"{name} by {engine}"):
                    samples = self.opened(name, "samples", engine)
                    self.assertEqual(dict(samples.sizes), {"id": rows, "level": 2})
                    self.assertEqual(samples.indexes["level"].to_list(), [1, 5])
                    self.assertEqual(samples.level.attrs["units"], "s")
                    self.assertEqual({samples[name].dims for name in samples.data_vars}, {("id", "level")})
                    self.assertTrue((samples.time.sel(level=1) == 1).all())
                    for column, values in alone.items():
                        numpy.testing.assert_array_equal(samples[column].isel(id=1), numpy.array(values, float), column)

    def test_samples_of_a_state_have_its_unit(self):
        self.write("few.toml", SCENE.replace("levels = [1, 5]", 'of = "x"\nlevels = [100, 200]'))
        self.salvo("run", "few.toml", "--set", "sweep.samples=3")
        with xarray.open_dataset(self.dir / "out/few/trajectories.hdf", group="samples") as samples:
            self.assertEqual(samples.level.attrs["units"], "m")
            numpy.testing.assert_allclose(samples.x.sel(level=200), 200, rtol=1e-9)

    def test_a_file_says_what_it_is(self):
        root = self.opened("trajectories.hdf")
        self.assertEqual(root.attrs["Conventions"], "CF-1.10")
        self.assertEqual(root.attrs["title"], "a test")
        self.assertRegex(root.attrs["source"], r"^salvo \d+\.\d+\.\d+, model shot_in_air$")
        self.assertEqual(root.attrs, self.opened("rows_000001.hdf").attrs)
        end = self.opened("trajectories.hdf", "end")
        self.assertEqual(end.speed.attrs["units"], "m/s")
        merged = xarray.merge([root, end.x])
        self.assertEqual(float(merged.x.sel(id=69_999)), self.csv.loc[69_999, "end.x"])

    def test_scales_are_those_of_hdf5(self):
        for name in ("trajectories.hdf", "rows_000001.hdf"):
            with h5py.File(self.out / name) as file:
                for scale, count in (("id", len(self.csv.columns) + len(file["samples"]) - 1),
                                     ("samples/level", len(file["samples"]) - 1)):
                    self.assertTrue(h5py.h5ds.is_scale(file[scale].id))
                    users = [(file[user].name, dimension) for user, dimension in file[scale].attrs["REFERENCE_LIST"]]
                    self.assertEqual(len(set(users)), count)
                    for user, dimension in users:
                        self.assertEqual(file[user].dims[dimension][0], file[scale])

    def test_bytes_do_not_depend_on_what_memory_held(self):
        for byte in ("85", "170"):  # glibc fills what it gives out, and what it takes back with the complement
            self.case.environment["MALLOC_PERTURB_"] = byte
            self.addCleanup(self.case.environment.pop, "MALLOC_PERTURB_", None)
            self.case.salvo("run", "sweep.toml", "--set", f"sweep.samples={self.ROWS}", "--out", f"filled{byte}")
            files = sorted((self.case.dir / f"filled{byte}").glob("*.hdf"))
            self.assertEqual([path.name for path in files], ["rows_000000.hdf", "rows_000001.hdf", "trajectories.hdf"])
            for path in files:
                self.assertTrue(path.read_bytes() == (self.out / path.name).read_bytes(), path.name)


if __name__ == "__main__":
    cli_test.SALVO = os.path.abspath(sys.argv.pop(1))
    unittest.main()
