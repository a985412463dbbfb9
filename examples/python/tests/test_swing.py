"""Tests of the module `swing` as it is installed; `test.sh` builds, installs and runs it.

The environment variable BITS names the program `bits`, whose numbers come from Rust alone.
"""

import os
import signal
import struct
import subprocess
import sys
import threading
import time
import unittest

import numpy
import swing


def start():
    return swing.State(1.0, 0.0)


class Steps(unittest.TestCase):
    def test_a_step_moves_the_state_in_place(self):
        state = start()
        swing.Pendulum().step(state, 0.01, 0.02)
        self.assertEqual(state.t, 0.01)
        self.assertLess(state.q[0], 1.0)

    def test_arrays_of_a_state_are_those_that_a_step_reads_and_writes(self):
        state, other = start(), swing.State([0.5], [0.0])
        q = state.q
        state.q[0] = 0.5
        for each in (state, other):
            swing.Pendulum().step(each, 0.01, numpy.array([0.02]))
        self.assertEqual(q[0], other.q[0])

    def test_a_copy_has_arrays_of_its_own(self):
        state = start()
        copy = state.copy()
        swing.Pendulum().step(state, 0.01, 0.02)
        self.assertEqual(repr(copy), "State(q=[1.0], p=[0.0], t=0.0)")

    def test_energy_of_states_and_of_paths(self):
        pendulum = swing.Pendulum(sigma=0.0)
        path = pendulum.trajectory(start(), 0.01, 1000)
        energies = pendulum.energy(path)
        self.assertEqual(energies.shape, (1001,))
        self.assertEqual(energies[0], pendulum.energy(start()))
        self.assertEqual(energies[0], -9.81 * numpy.cos(1.0))
        self.assertLess(numpy.ptp(energies), 1e-3)

    def test_state_from_velocity(self):
        state = swing.Pendulum().state_from_velocity(0.5, -2.0, t=3.0)
        self.assertEqual((state.q[0], state.p[0], state.t), (0.5, -2.0, 3.0))


class Paths(unittest.TestCase):
    def test_a_path_has_the_start_each_state_and_the_end(self):
        pendulum = swing.Pendulum()
        path = pendulum.trajectory(start(), 0.01, 10, seed=3)
        self.assertEqual((path["t"].shape, path["q"].shape, path["p"].shape), ((11,), (11, 1), (11, 1)))
        self.assertEqual((path["q"][0, 0], path["p"][0, 0]), (1.0, 0.0))
        some = pendulum.trajectory(start(), 0.01, 10, seed=3, every=4)
        numpy.testing.assert_array_equal(some, path[[0, 4, 8, 10]])
        only_start = pendulum.trajectory(start(), 0.01, 0)
        self.assertEqual(len(only_start), 1)

    def test_seed_and_path_give_the_noise(self):
        pendulum = swing.Pendulum()
        path = lambda **noise: pendulum.trajectory(start(), 0.01, 100, **noise).tobytes()
        self.assertEqual(path(seed=5, path=2), path(seed=5, path=2))
        self.assertNotEqual(path(seed=5, path=2), path(seed=5, path=3))
        self.assertNotEqual(path(seed=5, path=2), path(seed=6, path=2))

    def test_a_path_leaves_its_start_as_it_was(self):
        state = start()
        swing.Pendulum().trajectory(state, 0.01, 100)
        self.assertEqual(repr(state), repr(start()))

    def test_other_threads_run_while_steps_are_made(self):
        pendulum, ended = swing.Pendulum(), []

        def run():
            pendulum.trajectory(start(), 0.01, 3_000_000, every=3_000_000)
            ended.append(True)

        thread = threading.Thread(target=run)
        thread.start()
        turns = 0
        while not ended:
            turns += 1
            time.sleep(0.001)
        thread.join()
        self.assertGreater(turns, 20)


class Ensembles(unittest.TestCase):
    def test_statistics_are_those_of_the_paths(self):
        pendulum = swing.Pendulum()
        summary = pendulum.ensemble(start(), 0.01, 20, 100, seed=8, every=10, keep_ends=True)
        paths = [pendulum.trajectory(start(), 0.01, 20, seed=8, path=k, every=10) for k in range(100)]
        self.assertEqual(summary.names, ["q", "p", "energy"])
        self.assertEqual(list(summary.times), [0.0, 0.1, 0.2])
        self.assertEqual((summary.paths, summary.failed, summary.failures), (100, 0, []))
        q = numpy.array([path["q"][:, 0] for path in paths])
        numpy.testing.assert_allclose(summary["q"].mean, q.mean(axis=0), rtol=1e-13)
        numpy.testing.assert_allclose(summary["q"].variance, q.var(axis=0, ddof=1), atol=1e-15, rtol=1e-11)
        numpy.testing.assert_allclose(summary["q"].standard_error**2 * 100, summary["q"].variance)
        numpy.testing.assert_allclose(summary["q"].max, q.max(axis=0), rtol=1e-13)
        # the paths of an ensemble are computed in vector registers
        numpy.testing.assert_array_equal(summary.ends["t"], [path["t"][-1] for path in paths])
        for field in ("q", "p"):
            ends = [path[field][-1] for path in paths]
            numpy.testing.assert_allclose(summary.ends[field], ends, rtol=1e-13)

    def test_threads_do_not_change_the_numbers(self):
        pendulum = swing.Pendulum()
        run = lambda **more: pendulum.ensemble(start(), 0.01, 50, 500, seed=4, **more)["energy"]
        numpy.testing.assert_array_equal(run(threads=1).mean, run(threads=3).mean)
        numpy.testing.assert_array_equal(run().standard_error, run(threads=2).standard_error)

    def test_observe_names_what_is_computed(self):
        summary = swing.Pendulum().ensemble(start(), 0.01, 5, 10, observe=["p"])
        self.assertEqual(summary.names, ["p"])
        self.assertIsNone(summary.ends)
        with self.assertRaisesRegex(KeyError, "q"):
            summary["q"]

    def test_progress_is_reported_and_ends_with_all_paths(self):
        calls = []
        swing.Pendulum().ensemble(
            start(), 0.01, 2000, 5000, progress=lambda done, paths: calls.append((done, paths))
        )
        self.assertEqual(calls[-1], (5000, 5000))
        self.assertGreater(len(calls), 1)
        self.assertEqual(calls, sorted(calls))

    def test_an_exception_of_progress_ends_the_run(self):
        def fail(done, paths):
            raise RuntimeError("enough")

        begun = time.monotonic()
        with self.assertRaisesRegex(RuntimeError, "enough"):
            swing.Pendulum().ensemble(start(), 0.01, 10_000, 10_000_000, progress=fail)
        self.assertLess(time.monotonic() - begun, 5.0)

    def test_paths_that_fail_are_counted(self):
        summary = swing.Pendulum().ensemble(start(), 1.0, 100, 1000)
        self.assertGreater(summary.failed, 0)
        self.assertIn("take a smaller h", summary.failures[0])
        self.assertIn("first failure", str(summary))
        self.assertEqual(swing.Pendulum().ensemble(start(), 1.0, 100, 1000, refine=20).failed, 0)


class Errors(unittest.TestCase):
    def test_a_step_that_fails_leaves_the_state(self):
        pendulum = swing.Pendulum()
        with self.assertRaises(swing.StepError) as caught:
            pendulum.trajectory(start(), 2.0, 10_000, seed=0)
        self.assertIn("take a smaller h", str(caught.exception))
        states = caught.exception.states
        self.assertLess(len(states), 10_001)
        # the step that failed, alone
        last = states[-1]
        state = swing.State(last["q"], last["p"], t=last["t"])
        before = repr(state)
        with self.assertRaises(swing.StepError):
            for dw in numpy.linspace(-20, 20, 401):
                state = swing.State(last["q"], last["p"], t=last["t"])
                pendulum.step(state, 2.0, dw)
        self.assertEqual(repr(state), before)

    def test_refine_divides_a_step_that_fails(self):
        path = swing.Pendulum().trajectory(start(), 2.0, 2000, seed=0, refine=20)
        self.assertEqual((len(path), path["t"][-1]), (2001, 4000.0))

    def test_wrong_arguments_are_named(self):
        pendulum, nan = swing.Pendulum(), float("nan")
        for message, call in [
            ("^sigma is inf", lambda: swing.Pendulum(sigma=float("inf"))),
            ("^h is 0", lambda: pendulum.step(start(), 0.0, 0.1)),
            ("^h is NaN", lambda: pendulum.trajectory(start(), nan, 1)),
            ("^dw has 0 numbers and needs 1", lambda: pendulum.step(start(), 0.1)),
            ("^dw has 2 numbers", lambda: pendulum.step(start(), 0.1, [0.1, 0.2])),
            (r"^dw\[0\] is NaN", lambda: pendulum.step(start(), 0.1, nan)),
            ("^q has 2 numbers and needs 1", lambda: pendulum.step(swing.State([1, 2], 0), 0.1, 0.1)),
            ("^q has to be a number", lambda: swing.State("one", 0)),
            (r"^p\[0\] is NaN", lambda: pendulum.trajectory(swing.State(1, nan), 0.1, 1)),
            ("^steps is -1", lambda: pendulum.trajectory(start(), 0.1, -1)),
            ("^every is 0", lambda: pendulum.trajectory(start(), 0.1, 1, every=0)),
            ("^seed is 1180591620717411303424", lambda: pendulum.trajectory(start(), 0.1, 1, seed=2**70)),
            ("^refine is 64", lambda: pendulum.trajectory(start(), 0.1, 1, refine=64)),
            ("^paths is 0", lambda: pendulum.ensemble(start(), 0.1, 1, 0)),
            ("^steps is 0", lambda: pendulum.ensemble(start(), 0.1, 0, 1)),
            ("^threads is 0", lambda: pendulum.ensemble(start(), 0.1, 1, 1, threads=0)),
            ('^observe has "x"', lambda: pendulum.ensemble(start(), 0.1, 1, 1, observe=["x"])),
        ]:
            with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                call()

    def test_other_types_are_type_errors(self):
        for call in [
            lambda: swing.Pendulum(g="large"),
            lambda: swing.Pendulum(length=1.0),
            lambda: swing.Pendulum().trajectory(start(), 0.1, 1.5),
            lambda: swing.Pendulum().step([1.0, 0.0], 0.1, 0.1),
        ]:
            with self.assertRaises(TypeError):
                call()

    def test_too_many_states_are_a_memory_error(self):
        with self.assertRaisesRegex(MemoryError, "every"):
            swing.Pendulum().trajectory(start(), 0.01, 2**62)

    def test_an_ensemble_that_cannot_run(self):
        with self.assertRaisesRegex(swing.EnsembleError, "time"):
            swing.Pendulum().ensemble(swing.State(1.0, 0.0, t=1e300), 0.1, 10, 10)


class CtrlC(unittest.TestCase):
    """Each program says "ready", is interrupted, and has to end within a second."""

    def interrupt(self, call):
        program = f"""
import signal, time, swing
signal.signal(signal.SIGINT, signal.default_int_handler)
pendulum, start = swing.Pendulum(), swing.State(1.0, 0.0)
print("ready", flush=True)
try:
    {call}
    print("ended by itself")
except KeyboardInterrupt:
    print("interrupted", start, flush=True)
"""
        with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True) as run:
            self.assertEqual(run.stdout.readline(), "ready\n")
            time.sleep(0.5)
            run.send_signal(signal.SIGINT)
            sent = time.monotonic()
            output, _ = run.communicate(timeout=60)
        self.assertEqual(output, "interrupted State(q=[1.0], p=[0.0], t=0.0)\n")
        self.assertLess(time.monotonic() - sent, 1.0)

    def test_in_a_path(self):
        self.interrupt("pendulum.trajectory(start, 1e-6, 10**11, every=10**9)")

    def test_in_an_ensemble_of_many_paths(self):
        self.interrupt("pendulum.ensemble(start, 0.01, 1000, 10**9)")

    def test_in_an_ensemble_of_long_paths(self):
        self.interrupt("pendulum.ensemble(start, 1e-6, 10**10, 64)")


class Texts(unittest.TestCase):
    def test_help_has_the_texts_of_the_struct_and_of_the_methods(self):
        self.assertEqual(swing.Pendulum.__text_signature__, "(*, g=9.81, sigma=0.5)")
        self.assertIn("shaken at random", swing.Pendulum.__doc__)
        self.assertIn("Wiener increment", swing.Pendulum.step.__doc__)
        for one in (swing.Pendulum, swing.State, swing.Summary, swing.Statistics, swing.StepError):
            self.assertEqual(one.__module__, "swing")
            names = [name for name in vars(one) if not name.startswith("_")]
            lacking = sorted(name for name in names if not getattr(one, name).__doc__)
            self.assertIn(lacking, ([], ["g", "sigma"], ["t"]))

    def test_a_system_shows_its_parameters_and_its_step(self):
        pendulum = swing.Pendulum(g=1.0)
        self.assertEqual((repr(pendulum), pendulum.g), ("Pendulum(g=1.0, sigma=0.5)", 1.0))
        self.assertIn("midpoint", pendulum.plan.lower())


@unittest.skipUnless("BITS" in os.environ, "BITS names no program of Rust")
class Bits(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        lines = subprocess.run([os.environ["BITS"]], check=True, capture_output=True, text=True).stdout
        cls.expected = {name: bits for name, *bits in map(str.split, lines.splitlines())}

    def check(self, name, numbers):
        bits = [struct.pack(">d", x).hex() for x in numpy.ravel(numbers)]
        self.assertEqual(bits, self.expected[name], name)

    def test_steps(self):
        state = start()
        for dw in (0.02, -0.1, 0.3):
            swing.Pendulum().step(state, 0.01, dw)
        self.check("step", [state.t, *state.q, *state.p])

    def test_a_path(self):
        path = swing.Pendulum().trajectory(start(), 0.01, 1000, seed=42, path=7)
        self.check("path", numpy.column_stack([path["t"], path["q"], path["p"]])[1:])
        end = swing.Pendulum().trajectory(start(), 0.01, 1_000_000, seed=42, every=1_000_000)[-1]
        self.check("end", [*end["q"], *end["p"]])

    def test_an_ensemble(self):
        summary = swing.Pendulum().ensemble(start(), 0.01, 200, 1000, seed=42, every=50, keep_ends=True)
        self.check("times", summary.times)
        for name in summary.names:
            self.check(f"{name}.mean", summary[name].mean)
            self.check(f"{name}.standard_error", summary[name].standard_error)
        self.check("ends", summary.ends["q"])


if __name__ == "__main__":
    unittest.main()
