#!/usr/bin/python3
"""The scenes of the book's trajectories give the book's numbers, and those that follow from its formulas.

usage: book_trajectories_test.py SALVO REPOSITORY [unittest arguments]
"""
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

SALVO = None
REPOSITORY = None

INCH = 0.0254
MPH = 0.44704


class BookTrajectories(unittest.TestCase):
    maxDiff = None

    def document(self, name, *overrides):
        arguments = [argument for override in overrides for argument in ("--set", override)]
        with tempfile.TemporaryDirectory(prefix="salvo-book-") as folder:
            result = subprocess.run(
                [SALVO, "run", str(REPOSITORY / f"scenes/book/{name}.toml"), "--json", "--out", f"{folder}/out", *arguments],
                text=True, timeout=300, stdout=subprocess.PIPE, stderr=subprocess.PIPE, stdin=subprocess.DEVNULL)
        self.assertEqual(result.returncode, 0, f"{name} {overrides}\n{result.stderr}")
        return json.loads(result.stdout)

    def row(self, name, *overrides):
        return self.document(name, *overrides)["trajectories"][0]

    def assert_relative(self, value, expected, tolerance):
        self.assertLessEqual(abs(value - expected), tolerance * abs(expected), f"{value} is not {expected}")

    def assert_levels(self, samples, levels):
        self.assertEqual(len(samples), len(levels))
        for value, level in zip(samples, levels):
            self.assert_relative(value, level, 1e-14)

    def test_the_drop_of_a_rifle_bullet(self):
        row = self.row("rifle_drop")
        self.assertEqual(row["outcome"], "range")
        self.assertAlmostEqual(row["time"], 0.625, delta=1e-13)
        self.assertAlmostEqual(row["end.y"], -1.916015625, delta=1e-12)
        self.assertAlmostEqual(row["end.y"], -1.9, delta=0.05)  # as the book prints it
        self.assertAlmostEqual(row["end.speed"], 800.0234948, delta=5e-8)
        self.assertAlmostEqual(math.hypot(row["end.x"], row["end.y"]), 500.0036711, delta=5e-8)
        other = self.row("rifle_drop", "shot_in_air.gravity=9.8")
        self.assertAlmostEqual(other["end.y"], -1.9140625, delta=1e-12)

    def test_the_elevation_that_hits_what_is_level(self):
        row = self.row("rifle_drop", "shot_in_air.elevation=0.0038320688")
        self.assertAlmostEqual(row["end.y"], 0, delta=500 * 1e-10)
        self.assertAlmostEqual(row["time"], 0.6250045890, delta=1e-10)

    def test_marksman(self):
        samples = self.row("marksman")["samples"]
        self.assert_levels(samples["x"], [10, 100, 300])
        for x, y, expected, digits in zip(samples["x"], samples["y"], (0.766e-3, 76.64e-3, 0.68977), (5e-7, 5e-6, 5e-6)):
            self.assert_relative(y, -9.81 * (x / 800) ** 2 / 2, 1e-9)
            self.assertAlmostEqual(-y, expected, delta=digits)

    def test_near_and_far_zero(self):
        document = self.document("rifle_zero")
        elevation = document["solved"][0]["value"]
        self.assertAlmostEqual(elevation, 0.002465894399, delta=5e-13)
        self.assertAlmostEqual(elevation * 180 / math.pi * 60, 8.477121, delta=5e-7)
        row = document["trajectories"][0]
        samples = row["samples"]
        self.assert_levels(samples["x"], [21.746384927, 100, 160.873192463, 200, 300])
        self.assertAlmostEqual(samples["y"][0], 0, delta=1.2e-12)  # 5e-10 m along x, at 2.1e-3
        self.assertAlmostEqual(samples["y"][4], 0, delta=1e-13)
        self.assertAlmostEqual(row["apex.x"], 160.873192463, delta=5e-10)
        self.assertAlmostEqual(row["apex.y"], 0.148348554, delta=5e-10)
        # The path rises through the line of sight at the near zero.
        rising = self.row("rifle_zero", "samples.of=y", "samples.levels=[0]")["samples"]
        near = rising["x"][0]
        self.assertAlmostEqual(near, 21.746384927, delta=5e-10)
        # Vieta's identities.
        self.assert_relative(near * 300, 2 * (800 * math.cos(elevation)) ** 2 * 0.05 / 9.81, 1e-12)
        self.assert_relative(near + 300, 800 ** 2 * math.sin(2 * elevation) / 9.81, 1e-12)
        self.assert_relative(2 * row["apex.x"], near + 300, 1e-12)

    def test_a_parallel_bore_never_reaches_the_line_of_sight(self):
        samples = self.row("marksman", "shot_in_air.y=-0.05")["samples"]
        self.assertTrue(all(y < -0.05 for y in samples["y"]))
        self.assertEqual(samples["y"], sorted(samples["y"], reverse=True))

    def test_table_18_1(self):
        document = self.document("table_18_1")
        self.assertAlmostEqual(document["solved"][0]["value"], 2.928114e-3, delta=5e-10)
        samples = document["trajectories"][0]["samples"]
        drops = [y / INCH for y in samples["y"]]
        # The book's 250 yd has lost its minus sign.
        printed = [0, -4.6, -13.8, -28.6, -50.1, -115.47, -219.1]
        fitted = [0, -4.46, -13.80, -28.73, -50.02, -115.48, -219.10]
        for yards, x, drop, book, fit in zip((100, 150, 200, 250, 300, 400, 500), samples["x"], drops, printed, fitted):
            self.assertAlmostEqual(x, yards * 0.9144, delta=1e-12)
            self.assertAlmostEqual(drop, book, delta=0.25)
            self.assertAlmostEqual(drop, fit, delta=0.01)  # flat-fire formulas: within 0.005 in, printed to 0.005
        self.assertAlmostEqual(max(abs(a - b) for a, b in zip(drops, printed)), 0.140, delta=0.0005)
        self.assertAlmostEqual(drops[0], 0, delta=1e-9)
        # The near zero of the fit.
        near = self.row("table_18_1", "samples.of=y", "samples.levels=[0]")["samples"]["x"][0]
        self.assertAlmostEqual(near, 41.4, delta=0.05)

    def test_clicks_of_table_18_1(self):
        samples = self.row("table_18_1", f"samples.click={math.radians(0.25 / 60)}")["samples"]
        for click, x, y, expected in zip(samples["clicks_up"], samples["x"], samples["y"], (0, 12, 26, 44, 64, 110, 167)):
            self.assertAlmostEqual(click, math.degrees(math.atan(-y / x)) * 60 / 0.25, delta=1e-9)
            self.assertLessEqual(abs(round(click) - expected), 1)
        self.assertEqual([abs(click) for click in samples["clicks_right"]], [0] * 7)

    def test_wind_deflection(self):
        row = self.row("wind_deflection")
        samples = row["samples"]
        self.assert_levels(samples["x"], [20, 100, 300, 600])
        k, v, w = 0.7e-3, 800, 10 * MPH
        # Without gravity the path in the air is straight: its length is x u / v, and the time follows from it.
        u = math.hypot(v, w)
        for x, time, z in zip(samples["x"], samples["time"], samples["z"]):
            self.assert_relative(time, math.expm1(k * x * u / v) / (k * u), 1e-10)
            self.assert_relative(z, w * (time - x / v), 1e-8)
            # The flat-fire time, which leaves the wind out of the speed.
            self.assert_relative(z, w * (math.expm1(k * x) / (k * v) - x / v), 5e-5)
        for z, expected, digits in zip((samples["z"][0], samples["z"][2], samples["z"][3]), (0.786e-3, 0.18902, 0.81394),
                                       (5e-7, 5e-6, 2.5e-5)):
            self.assertAlmostEqual(z, expected, delta=digits)
        # More than 1 m at 600 m needs about 12.3 mph.
        for wind, more in (("12.2 mph", False), ("12.4 mph", True)):
            z = self.row("wind_deflection", f"shot_in_air.wind_z={wind}")["samples"]["z"][3]
            self.assertEqual(z > 1, more)

    def test_symmetries_of_the_wind(self):
        right = self.row("wind_deflection")["samples"]
        left = self.row("wind_deflection", "shot_in_air.wind_z=-10 mph")["samples"]
        self.assertEqual(right["z"], [-z for z in left["z"]])
        for same in ("time", "x", "y", "vx", "vy"):
            self.assertEqual(right[same], left[same])
        calm = self.row("wind_deflection", "shot_in_air.wind_z=0")["samples"]
        self.assertEqual(calm["z"], [0, 0, 0, 0])
        head = self.row("wind_deflection", "shot_in_air.wind_z=0", "shot_in_air.wind_x=-5")["samples"]
        self.assertEqual(head["z"], [0, 0, 0, 0])
        self.assertTrue(all(a > b for a, b in zip(head["time"], calm["time"])))

    def test_table_6_5(self):
        rows = self.document("skydiver")["trajectories"]
        lines = [line.split(",") for line in (REPOSITORY / "scenes/book/table_6_5.csv").read_text().splitlines()]
        lines = [line for line in lines if len(line) == 5][1:]
        self.assertEqual(len(lines), 5)
        computed = (200.882, 40.157, 119.757, 122.938, 33.101)  # km/h
        metres = (55.80056, 11.15480, 33.26589, 34.14939, 9.19476)
        printed = ((201, 1 / 201), (40, 1 / 40), (121, 0.02), (116, 0.07), (32, 0.05))
        for row, line, kmh, ms, (book, part) in zip(rows, lines, computed, metres, printed):
            weight, area = float(line[1]), float(line[2])
            self.assert_relative(float(line[3]), weight / 9.8, 1e-14)
            self.assert_relative(float(line[4]), 1.225 * 0.5 * area / 2 / (weight / 9.8), 1e-14)
            self.assertEqual(row["outcome"], "time limit")
            speed = row["end.speed"]
            self.assert_relative(speed, math.sqrt(2 * weight / (0.5 * 1.225 * area)), 1e-9)
            self.assertAlmostEqual(speed, ms, delta=6e-6)
            self.assert_relative(speed * 3.6, kmh, 1e-5)
            self.assert_relative(speed * 3.6, book, part)

    def test_the_fall_of_the_skydiver(self):
        row = self.document("skydiver")["trajectories"][0]
        samples = row["samples"]
        self.assertEqual(samples["time"], [1, 5, 10, 20])
        for speed, expected in zip(samples["speed"], (9.700469727, 39.366176756, 52.568772733, 55.701396804)):
            self.assertAlmostEqual(speed, expected, delta=1e-9)
        self.assertAlmostEqual(samples["y"][2], -347.112236996, delta=1e-9)
        # 95 % of the terminal velocity.
        at = self.row("skydiver", "samples.levels=[10.430041]")["samples"]["speed"][0]
        self.assert_relative(at, 0.95 * math.sqrt(2 * 801 / (0.5 * 1.225 * 0.84)), 1e-7)

    def test_the_cannon_hits_the_face_of_its_target(self):
        row = self.row("cannon")
        self.assertEqual(row["outcome"], "target_front")
        self.assertAlmostEqual(row["time"], 6.385243, delta=5e-7)
        self.assertAlmostEqual(row["end.x"], 395, delta=1e-9)
        self.assertAlmostEqual(row["end.z"], 44.306349, delta=1e-6)

    def test_four_of_1430_shots_hit(self):
        outcomes = self.document("cannon_sweep")["statistics"]["outcomes"]
        self.assertEqual(sum(outcomes.values()), 1430)
        self.assertEqual(sum(count for name, count in outcomes.items() if name.startswith("target")), 4)
        self.assertEqual(outcomes["ground"], 1426)

    def test_the_cannon_with_drag_and_wind(self):
        samples = self.row("cannon_wind")["samples"]
        exact = ((43.196963220, 38.752312523, -0.453535785), (129.478306642, 50.737466981, -8.034779557),
                 (158.368821939, -64.830214395, -22.775411871))
        for k, (x, y, z) in enumerate(exact):
            for column, value in (("x", x), ("y", y), ("z", z)):
                self.assertAlmostEqual(samples[column][k], value, delta=1e-6)

    def test_the_boat(self):
        samples = self.row("boat")["samples"]
        for k, (t, v) in enumerate(((1, 1.903251639), (5, 7.869386806), (6.5, 9.559084))):
            self.assertEqual(samples["time"][k], t)
            self.assertAlmostEqual(samples["v"][k], v, delta=1e-6)

    def test_spin_carries_a_baseball(self):
        rows = self.document("baseball_spin")["trajectories"]
        for row, (reach, flight) in zip(rows, ((136.272, 3.4013), (155.020, 3.9147), (178.949, 4.5918),
                                               (209.788, 5.5083), (248.916, 6.7665))):
            self.assertAlmostEqual(row["end.x"], reach, delta=5e-4)
            self.assertAlmostEqual(row["time"], flight, delta=5e-5)

    def test_lift_carries_a_golf_ball(self):
        rows = self.document("golf_lift")["trajectories"]
        for row, reach in zip(rows, (87.83, 125.45, None, 148.01, 170.02)):
            if reach:
                self.assertAlmostEqual(row["end.x"], reach, delta=0.01)
        self.assertAlmostEqual(rows[2]["end.x"] - rows[0]["end.x"], 59, delta=1)  # "up to 59 m"

    def test_the_rocket(self):
        row = self.row("rocket")
        for k, (v, h) in enumerate(((165.401289145, 803.883976989), (597.687359847, 8171.884810722),
                                    (1702.726829685, 40730.926812584))):
            self.assert_relative(row["samples"]["vy"][k], v, 1e-6)
            self.assert_relative(row["samples"]["y"][k], h, 1e-6)
        self.assertAlmostEqual(row["apex.time"], 233.748, delta=1e-3)
        self.assertAlmostEqual(row["apex.y"], 188653.307, delta=0.1)
        self.assertAlmostEqual(row["burnout.time"], 60, delta=1e-9)


if __name__ == "__main__":
    SALVO = os.path.abspath(sys.argv.pop(1))
    REPOSITORY = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main()
