"""What is done beside and after the filter.

Dead reckoning, attitude updates, corrections, smoothers, levelling.
"""

import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from footnav import Config, Navigator, Recording, Trajectory, load_config, simulate, track
from footnav.config import Alignment, Correction, Filter, Smoother
from footnav.errors import ConfigError, DataError
from footnav.health import Flag
from footnav.simulation import Gait, Route, SensorErrors
from footnav.tracking import with_ranges_of

KINDS = {
    "stepwise": Config(smoother=Smoother(kind="stepwise")),
    "rts": Config(smoother=Smoother(kind="rts")),
    "lwi": Config(correction=Correction(kind="lwi")),
    "rv": Config(correction=Correction(kind="rv")),
}
STEP_BY_STEP = Config(filter=Filter(covariance_interval=0.0))
"""The filter as it is under a smoother."""
STANDING = np.array([0.0, 0.0, Config().gravity])
FLOATS = ("position", "velocity", "quaternion", "position_std", "gyro_bias", "accel_bias")


def dead_reckoning(correction="none"):
    return Config(filter=Filter(kind="dr"), correction=Correction(kind=correction))


def error(states, truth):
    """Return the distance from the truth, m, at each sample."""
    return np.linalg.norm(states.position - truth.position, axis=1)


@pytest.fixture(scope="module")
def walks():
    """Simulate ten walks around a square of 10 m with a calibrated MPU6050, and their truth."""
    sensor = SensorErrors.preset("mpu6050")
    errors = {"scale_std": 0.0, "misalignment_std": 0.0}
    sensor = sensor.replace(
        accel=sensor.accel.replace(**errors),
        gyro=sensor.gyro.replace(**errors),
        gyro_g_sensitivity_std=0.0,
    )
    gait = Gait.preset("walk")
    return [
        simulate(Route.square(10.0), gait, sensor, seed=seed, rate_hz=100.0) for seed in range(10)
    ]


@pytest.fixture(scope="module")
def walk(walks):
    return walks[0]


@pytest.mark.parametrize("name", KINDS)
def test_every_sample_has_a_sound_row(name, walk):
    recording, _ = walk
    states = track(recording, KINDS[name])
    np.testing.assert_array_equal(states.t, recording.t)
    for column in FLOATS:
        assert np.isfinite(getattr(states, column)).all(), column
    np.testing.assert_allclose(np.linalg.norm(states.quaternion, axis=1), 1.0, atol=1e-9)
    np.testing.assert_array_equal(states.zero_velocity, track(recording).zero_velocity)


class TestFilterKinds:
    """What a stance corrects: the velocity alone, nothing, or all that it depends on."""

    def test_dead_reckoning_stops_in_stance_and_learns_nothing_from_it(self, walk):
        recording, _ = walk
        states = track(recording, dead_reckoning())
        walking = (states.flags & int(Flag.ALIGNING)) == 0
        assert (states.velocity[walking & states.zero_velocity] == 0).all()
        assert np.ptp(states.gyro_bias[walking], axis=0).max() == 0
        assert np.ptp(states.accel_bias[walking], axis=0).max() == 0
        assert states.health.counters.zero_velocity_updates > 0
        assert states.health.counters.zero_angular_rate_updates == 0

    @pytest.mark.filterwarnings("ignore:.*not seen at rest")
    def test_the_free_inertial_solution_ignores_stances(self, walk):
        recording, _ = walk
        unaided = track(
            recording, Config(filter=Filter(kind="ins")), detector=np.ones(len(recording), bool)
        )
        aided_by_rest = Config(filter=Filter(zero_angular_rate=False))
        never = track(recording, aided_by_rest, detector=np.zeros(len(recording), bool))
        np.testing.assert_array_equal(unaided.position, never.position)

    @pytest.mark.filterwarnings("ignore:.*not seen at rest")
    def test_each_learns_more_than_the_one_before(self, walks):
        def median(config):
            return np.median(
                [error(track(recording, config), truth)[-1] for recording, truth in walks]
            )

        unaided, stopped, filtered = map(
            median, (Config(filter=Filter(kind="ins")), dead_reckoning(), Config())
        )
        assert filtered < 0.5
        assert stopped > 3 * filtered
        assert unaided > 10 * stopped

    def test_its_uncertainty_covers_dead_reckoning(self, walks):
        """Within three sigma on all axes, in at least eight of the walks."""
        inside = 0
        for recording, truth in walks:
            states = track(recording, dead_reckoning())
            off = np.abs(states.position[-1] - truth.position[-1])
            inside += (off < 3 * states.position_std[-1]).all()
        assert inside >= 8


class TestCorrections:
    """LWI and RV."""

    def test_they_take_most_of_the_error_off_dead_reckoning(self, walks):
        plain, lwi, rv = (
            np.median(
                [
                    error(track(recording, dead_reckoning(kind)), truth)[-1]
                    for recording, truth in walks
                ]
            )
            for kind in ("none", "lwi", "rv")
        )
        assert lwi < 0.5 * plain
        assert rv < 0.5 * plain

    @pytest.mark.parametrize("kind", ["lwi", "rv"])
    @pytest.mark.parametrize("filter_kind", ["dr", "kf"])
    def test_the_position_is_the_integral_of_the_velocity(self, kind, filter_kind, walk):
        recording, _ = walk
        states = track(
            recording, Config(filter=Filter(kind=filter_kind), correction=Correction(kind=kind))
        )
        mean = (states.velocity[1:] + states.velocity[:-1]) / 2
        way = np.cumsum(mean * np.diff(states.t)[:, None], axis=0)
        np.testing.assert_allclose(states.position[1:] - states.position[0], way, atol=1e-9)

    def test_nothing_is_wrong_nothing_is_changed(self):
        """An ideal sensor with given stances at rest: the residual velocities are rounding."""
        still = np.zeros((600, 3))
        recording = Recording(np.arange(600) / 100, still + STANDING, still)
        stances = (np.arange(600) // 50) % 2 == 0
        for kind in ("lwi", "rv"):
            states = track(recording, dead_reckoning(kind), detector=stances)
            assert np.abs(states.position).max() < 1e-12

    def test_the_velocity_in_stance_has_no_mean(self, walk):
        recording, _ = walk
        states = track(recording, dead_reckoning("lwi"))
        edges = np.flatnonzero(np.diff(states.zero_velocity.astype(int)))
        middle = len(edges) // 2
        start, end = next(
            (a, b) for a, b in itertools.pairwise(edges[middle:] + 1) if states.zero_velocity[a]
        )
        np.testing.assert_allclose(states.velocity[start:end].mean(axis=0), 0.0, atol=1e-12)


class TestSmoothers:
    """Over the whole recording and step by step."""

    def test_the_last_state_is_the_filters(self, walk):
        recording, _ = walk
        filtered = track(recording, STEP_BY_STEP)
        for name in ("rts", "stepwise"):
            smoothed = track(recording, KINDS[name])
            for column in FLOATS:
                np.testing.assert_array_equal(
                    getattr(smoothed, column)[-1], getattr(filtered, column)[-1]
                )

    def test_later_data_do_not_increase_the_uncertainty(self, walk):
        recording, _ = walk
        filtered, stepwise, whole = (
            track(recording, c) for c in (STEP_BY_STEP, KINDS["stepwise"], KINDS["rts"])
        )
        assert (stepwise.position_std <= filtered.position_std * (1 + 1e-9)).all()
        assert (whole.position_std <= stepwise.position_std * (1 + 1e-6) + 1e-9).all()

    def test_the_velocity_in_the_swing_is_more_accurate(self, walks):
        def rms(config):
            return (
                np.median(
                    [
                        ((track(r, config).velocity - truth.velocity) ** 2).mean()
                        for r, truth in walks
                    ]
                )
                ** 0.5
            )

        filtered, stepwise, whole = map(rms, (Config(), KINDS["stepwise"], KINDS["rts"]))
        assert stepwise < filtered
        assert whole < filtered

    def test_no_jump_is_left_at_the_start_of_a_stance(self, walk):
        """The filter's position jumps where a stance begins.

        The velocity of a smoothed one is its derivative.
        """
        recording, _ = walk

        def jump(config):
            states = track(recording, config)
            mean = (states.velocity[1:] + states.velocity[:-1]) / 2
            return np.linalg.norm(
                np.diff(states.position, axis=0) - mean * np.diff(states.t)[:, None], axis=1
            ).max()

        assert jump(KINDS["rts"]) < 0.2 * jump(Config())

    def test_a_gap_too_long_to_be_bridged_is_not_smoothed_over(self, walk):
        recording, _ = walk
        keep = (recording.t < 15) | (recording.t > 18)
        cut = Recording(recording.t[keep], recording.accel[keep], recording.gyro[keep])
        first = recording.t < 15
        alone = Recording(recording.t[first], recording.accel[first], recording.gyro[first])
        with pytest.warns(UserWarning, match="missing"):
            whole = track(cut, KINDS["rts"], detector=track(recording).zero_velocity[keep])
        part = track(alone, KINDS["rts"], detector=track(recording).zero_velocity[first])
        np.testing.assert_array_equal(whole.position[: len(part)], part.position)

    def test_on_recordings_with_the_truth_smoothing_helps(self, data_dir):
        def armse(path, config):
            with np.load(path) as file:
                recording = Recording(file["t"], file["accel"], file["gyro"], name=path.stem)
                truth = file["position"]
            states = track(recording, with_ranges_of(recording, config))
            estimate, reference = (
                p[:, 0] - p[0, 0] + 1j * (p[:, 1] - p[0, 1]) for p in (states.position, truth)
            )
            turn = np.vdot(estimate, reference)
            return np.sqrt((np.abs(estimate * turn / abs(turn) - reference) ** 2).mean())

        paths = sorted((data_dir / "vicon").glob("*.npz"))[::4]
        filtered, stepwise, whole = (
            np.mean([armse(path, c) for path in paths])
            for c in (Config(), KINDS["stepwise"], KINDS["rts"])
        )
        assert stepwise < filtered
        assert whole < filtered


class TestStreaming:
    """What is causal works in a stream, and the rest is refused."""

    @pytest.mark.parametrize("longest_step", [0.5, 2.0])
    def test_the_stepwise_smoother_is_the_batch_to_the_bit(self, longest_step, walk):
        recording, _ = walk
        config = Config(smoother=Smoother(kind="stepwise", longest_step=longest_step))
        batch = track(recording, config)
        navigator = Navigator(config, recording.rate_hz)
        cuts = np.sort(np.random.default_rng(3).integers(0, len(recording), 40))
        columns = (recording.t, recording.accel, recording.gyro)
        blocks = zip(*(np.split(column, cuts) for column in columns), strict=True)
        states = Trajectory.concatenate(
            [*(navigator.push_block(*block) for block in blocks), navigator.flush()]
        )
        for column in (*FLOATS, "t", "zero_velocity", "flags"):
            np.testing.assert_array_equal(
                getattr(states, column), getattr(batch, column), err_msg=column
            )

    def test_its_delay_is_fixed_and_stated(self, walk):
        recording, _ = walk
        plain = Navigator(Config(), 100.0).latency
        navigator = Navigator(Config(smoother=Smoother(kind="stepwise", longest_step=1.5)), 100.0)
        assert navigator.latency == plain + 150
        batch = track(recording, Config(smoother=Smoother(kind="stepwise", longest_step=1.5)))
        for k, row in enumerate(
            np.column_stack([recording.t, recording.accel, recording.gyro])[:1000]
        ):
            assert navigator.push(*row) == (k >= navigator.latency)
            if k >= navigator.latency:
                assert navigator.t == recording.t[k - navigator.latency]
                np.testing.assert_array_equal(
                    navigator.position, batch.position[k - navigator.latency]
                )

    def test_reset_restarts_the_navigator(self, walk):
        recording, _ = walk
        navigator = Navigator(KINDS["stepwise"], recording.rate_hz)
        columns = (recording.t, recording.accel, recording.gyro)
        first = Trajectory.concatenate([navigator.push_block(*columns), navigator.flush()])
        navigator.reset()
        navigator.push_block(*(column[:777] for column in columns))
        navigator.reset()
        second = Trajectory.concatenate([navigator.push_block(*columns), navigator.flush()])
        np.testing.assert_array_equal(first.position, second.position)

    @pytest.mark.parametrize("name", ["rts", "lwi", "rv"])
    def test_settings_that_need_the_whole_recording_are_refused(self, name):
        with pytest.raises(
            ConfigError,
            match=r"needs the whole recording: use track\(\), or smoother.kind = \"stepw",
        ):
            Navigator(KINDS[name], 100.0)


class TestFineLevelling:
    """The second stage of the alignment."""

    def test_it_levels_better_than_the_coarse_step(self):
        """Six seconds of a tilted, noisy sensor at rest with a small prior accelerometer bias."""
        mounting = Rotation.from_euler("xyz", [0.2, -0.1, 0.0])
        up = mounting.inv().apply([0, 0, 1])
        settings = Config(
            sensor=Config().sensor.replace(accel_bias_std=1e-4, accel_noise_density=0.02),
            filter=Filter(specific_force_noise=0.0, zero_velocity_std=0.001),
            alignment=Alignment(duration=0.3, fine_duration=5.0, rest_accel_std=0.5),
        )
        coarse, fine = [], []
        for seed in range(20):
            noise = np.random.default_rng(seed).normal(size=(2, 600, 3))
            accel = Config().gravity * up + 0.2 * noise[0]
            states = track(Recording(np.arange(600) / 100, accel, 1e-4 * noise[1]), settings)
            tilt = np.hypot(*Rotation.from_quat(states.quaternion).apply(up).T[:2])
            coarse.append(tilt[40])
            fine.append(tilt[550])
        assert np.median(fine) < 0.5 * np.median(coarse)

    def test_the_walk_starts_after_it(self):
        still = np.zeros((800, 3))
        recording = Recording(np.arange(800) / 100, still + STANDING, still)
        states = track(recording, Config(alignment=Alignment(fine_duration=3.0)))
        aligning = (states.flags & int(Flag.ALIGNING)) != 0
        assert states.t[aligning][-1] == pytest.approx(4.0, abs=0.15)
        assert (states.position[aligning] == 0).all()

    def test_a_foot_that_moves_ends_it(self, walk):
        recording, truth = walk
        states = track(recording, Config(alignment=Alignment(fine_duration=60.0)))
        aligning = (states.flags & int(Flag.ALIGNING)) != 0
        set_out = recording.t[np.linalg.norm(truth.velocity, axis=1) > 0.1][0]
        assert states.t[aligning][-1] == pytest.approx(set_out, abs=0.25)
        assert error(states, truth)[-1] < 1.0


class TestAttitudeUpdates:
    """A foot at rest whose roll is off by two degrees after shaking at the start."""

    def tilted(self, update):
        still = np.zeros((600, 3))
        off = np.where(np.arange(600) < 110, 0.035 * 9.81, 0.0)[:, None] * [0, 1, 0]
        recording = Recording(np.arange(600) / 100, STANDING + off, still)
        update = {"attitude_update": update, "attitude_threshold": 0.1} if update != "none" else {}
        settings = Config(
            sensor=Config().sensor.replace(accel_bias_std=1e-3),
            filter=Filter(zero_velocity_std=10.0, zero_angular_rate=False, **update),
        )
        states = track(recording, settings, detector=np.ones(600, bool))
        return np.abs(Rotation.from_quat(states.quaternion[-1]).as_euler("xyz")[0])

    def test_both_correct_a_tilt_that_the_velocity_does_not_show(self):
        assert self.tilted("none") > 0.02
        assert self.tilted("gravity") < 0.005
        assert self.tilted("iaa") < 0.005

    def test_they_apply_only_where_the_specific_force_is_gravity(self):
        """Two m/s^2 too much are above the threshold, so nothing is observed."""
        still = np.zeros((600, 3))
        pushed = np.where(np.arange(600) <= 100, 0.0, 1.0)[:, None] * [0, 0.3, 2.0]
        recording = Recording(np.arange(600) / 100, STANDING + pushed, still)
        update = {"attitude_update": "gravity", "attitude_std": 1e-4}

        def states(**update):
            settings = Config(
                filter=Filter(zero_angular_rate=False, zero_velocity_std=1.0, **update)
            )
            return track(recording, settings, detector=np.ones(600, bool)).quaternion

        np.testing.assert_array_equal(states(**update, attitude_threshold=0.1), states())
        assert np.abs(states(**update, attitude_threshold=5.0) - states()).max() > 1e-6


class TestBadInput:
    """Settings and recordings that the stages cannot work with."""

    @pytest.mark.parametrize(
        ("settings", "message"),
        [
            (
                {"filter": {"attitude_update": "iaa"}},
                "attitude_update needs filter.attitude_threshold",
            ),
            (
                {"filter": {"attitude_update": "gravity"}},
                "three standard deviations of the accelerometer at rest",
            ),
            (
                {"filter": {"attitude_update": "iaa", "attitude_threshold": 0.1, "kind": "dr"}},
                "corrects the states of a Kalman filter",
            ),
            (
                {"filter": {"attitude_threshold": 0.0}},
                "filter.attitude_threshold = 0: expected a positive number",
            ),
            (
                {"filter": {"attitude_std": -1.0}},
                "filter.attitude_std = -1: expected a positive number",
            ),
            (
                {"filter": {"kind": "ins"}, "correction": {"kind": "rv"}},
                'filter.kind = "ins" does not use',
            ),
            ({"correction": {"kind": "rv"}, "smoother": {"kind": "rts"}}, "keep one of them"),
            (
                {"filter": {"kind": "dr"}, "smoother": {"kind": "rts"}},
                "smoother.kind smooths the estimates",
            ),
            (
                {"smoother": {"longest_step": 0.01}},
                "smoother.longest_step = 0.01: expected between 0.1 and 60 s",
            ),
            ({"smoother": {"kind": "kalman"}}, "smoother.kind"),
            ({"correction": {"kind": "vr"}}, "correction.kind"),
            (
                {"alignment": {"fine_duration": -1.0}},
                "alignment.fine_duration = -1: expected zero or a positive",
            ),
        ],
    )
    def test_settings_that_do_not_fit_are_refused(self, settings, message, tmp_path):
        import tomli_w

        path = tmp_path / "shoe.toml"
        path.write_bytes(tomli_w.dumps(settings).encode())
        with pytest.raises(ConfigError, match=message):
            load_config(path)

    @pytest.mark.parametrize("name", KINDS)
    def test_a_recording_without_a_stance_cannot_be_refined(self, name, walk):
        recording, _ = walk
        named = Recording(recording.t, recording.accel, recording.gyro, name="swing.csv")
        with pytest.raises(
            DataError,
            match=r"^swing.csv: the foot was never found at rest in .* samples.*another det",
        ):
            track(named, KINDS[name], detector=np.zeros(len(recording), bool))
