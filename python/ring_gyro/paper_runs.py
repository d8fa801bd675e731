"""What is simulated to reproduce the paper, and how its numbers are read from the runs."""

import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import yaml

from .tools import Progress, Run, Series, find_config, run_jobs, run_tool, simulate

PARAMETERS = ("gamma1", "gamma2", "mu1", "mu2", "ks")
TWELVE = math.radians(12.0)


@dataclass
class Device:
    """A preset: its file and what the averaged model needs of it."""
    config: Path
    values: dict

    @classmethod
    def preset(cls, name: str) -> "Device":
        config = find_config(name)
        return cls(config, yaml.safe_load(config.read_text()))

    def number(self, section: str, key: str) -> float:
        """PyYAML takes 14.0e3 for text."""
        return float(self.values[section][key])

    @property
    def decay(self) -> float:
        """xi0 w0 [1/s]."""
        return (math.pi * self.number("device", "natural_frequency") /
                self.number("device", "quality_factor"))

    @property
    def gamma(self) -> tuple:
        return self.number("resonator", "gamma1"), self.number("resonator", "gamma2")

    @property
    def drive_gain(self) -> float:
        """ks as the loops assume it."""
        return self.number("device", "drive_gain")

    def drift(self, gamma, degrees) -> np.ndarray:
        """Second harmonic of the sensed rate, (18) with b = 0 [deg/s]."""
        angle = np.radians(2.0 * np.asarray(degrees))
        return -math.degrees(self.decay) * (gamma[0] * np.sin(angle) - gamma[1] * np.cos(angle))

    def beta(self, gamma, ks: float, degrees) -> np.ndarray:
        """Sustain gain that keeps a, (16) with b = 0 [s]."""
        angle = np.radians(2.0 * np.asarray(degrees))
        return 2.0 * self.decay / ks * (1.0 + gamma[0] * np.cos(angle) + gamma[1] * np.sin(angle))

    def threshold(self, gamma) -> float:
        """Rate below which the pattern does not turn, xi0 w0 |gamma| [deg/s]."""
        return math.degrees(self.decay) * math.hypot(*gamma)


@dataclass
class Settings:
    """How much is run; `quick` is for a test that everything works."""
    quick: bool = False
    keep_bags: bool = False
    workers: int = 2
    identification: float = 190.0  # s: 6 turns at the mean rate
    case: float = 190.0
    simulation: float = 300.0      # s, section 6
    sweep_points: int = 121
    steering: tuple = (5.0, 6.0, 8.0, 12.0, 18.0, 24.0, 36.0, 48.0)   # deg/s
    steering_turns: float = 2.0
    thresholds: tuple = (1.0, 2.0, 3.0, 3.5, 3.9, 4.05, 4.2, 4.3, 4.5, 5.0, 6.0, 8.0)
    low_thresholds: tuple = (0.1, 0.2, 0.3, 0.4, 0.45, 0.5, 0.6, 0.8, 1.0, 2.0)
    most_threshold: float = 600.0  # s, of one run of the threshold
    frequencies: tuple = (1 / 360, 1 / 60, 0.1, 1.0, 10.0, 30.0, 60.0, 100.0, 130.0, 160.0, 200.0,
                          240.0, 280.0, 320.0, 360.0, 400.0, 430.0, 460.0)
    low_frequencies: tuple = (1 / 360, 1 / 120, 1 / 60, 1 / 30, 0.1, 1.0)

    @classmethod
    def short(cls, **others) -> "Settings":
        return cls(quick=True, identification=42.0, case=36.0, simulation=15.0, sweep_points=25,
                   steering=(48.0,), steering_turns=1.0, thresholds=(2.0, 8.0),
                   low_thresholds=(0.2, 8.0), most_threshold=60.0,
                   frequencies=(10.0, 100.0, 300.0), low_frequencies=(1.0,), **others)


def final_estimate(run: Run) -> dict:
    final = run.summary["final_estimate"]
    return {name: final["parameters"][name]["estimate"] for name in PARAMETERS}


def residual(run: Run) -> tuple:
    final = run.summary["final_estimate"]
    return final["residual_gamma1"], final["residual_gamma2"]


def peak_to_peak(run: Run) -> float:
    """Of harmonics 1 to 8 of the rate [deg/s]."""
    return math.degrees(run.drift["peak_to_peak_rad_s"])


def amplitudes(run: Run) -> np.ndarray:
    """Of harmonics 1 to 8 [deg/s]."""
    return np.degrees(np.hypot(run.drift["cosine_rad_s"], run.drift["sine_rad_s"]))


def fitted_rate(drift: dict, degrees, harmonics=range(1, 9), mean: bool = True) -> np.ndarray:
    """Sensed rate of the fit [deg/s]; the pattern turns the other way."""
    theta = np.radians(degrees)
    rate = np.full_like(theta, drift["mean_pattern_rate_rad_s"] if mean else 0.0)
    for n in harmonics:
        rate += drift["cosine_rad_s"][n - 1] * np.cos(n * theta)
        rate += drift["sine_rad_s"][n - 1] * np.sin(n * theta)
    return -np.degrees(rate)


ANGLES = np.linspace(0.0, 360.0, 1441)


def gamma2_for(device: Device, gamma1: float, target: float, drift: dict, sign: int) -> float:
    """Residual gamma2 with which the averaged model, and the 4th harmonic as it was measured, make
    `target` deg/s from peak to peak."""
    fourth = fitted_rate(drift, ANGLES, harmonics=(4,), mean=False)
    low, high = 0.0, 0.2
    for _ in range(60):
        middle = 0.5 * (low + high)
        rate = device.drift((gamma1, sign * middle), ANGLES) + fourth
        low, high = (middle, high) if np.ptp(rate) < target else (low, middle)
    return sign * 0.5 * (low + high)


def settled_since(time, values, tolerance, final) -> float:
    """From when on every value is within its tolerance of the final one; NaN when never."""
    outside = np.any([np.abs(value - last) > limit
                      for value, limit, last in zip(values, tolerance, final)], axis=0)
    after = np.flatnonzero(outside)
    first = after[-1] + 1 if len(after) else 0
    return float(time[first]) if first < len(time) else math.nan


# What counts as converged in the figures: the estimates stay this close to their last values.
GAMMA_BAND, MU_BAND, KS_BAND = 1e-3, 1e-7, 2e-3


def convergence_time(run: Run) -> float:
    series = run.series("estimates")
    final = final_estimate(run)
    tolerance = (GAMMA_BAND, GAMMA_BAND, MU_BAND, MU_BAND, KS_BAND * final["ks"])
    lock = run.summary["ring_up_s"] or 0.0
    return settled_since(series["time_s"], [series[name] for name in PARAMETERS], tolerance,
                         [final[name] for name in PARAMETERS]) - lock


@dataclass
class Turning:
    """Mean precession at one true rotation rate."""
    rate: float        # deg/s
    mean: float        # deg/s, sensed
    turned: float      # deg, whole run


def turning(run: Run, rate: float) -> Turning:
    """Mean sensed rate over the last whole half turns, or at the end of a run that stands."""
    loops = run.series("loops")
    time, theta = loops["time_s"], -loops["theta_deg"]
    chosen = time > run.summary["ring_up_s"] + 1.0
    time, theta = time[chosen], theta[chosen]
    turned = theta[-1] - theta[0]
    halves = math.floor(turned / 180.0)
    # The way to the angle at which it comes to rest, less than half a turn, is no turning.
    if halves < 1:
        late = time > time[0] + 0.8 * (time[-1] - time[0])
        return Turning(rate, float(np.polyfit(time[late], theta[late], 1)[0]), float(turned))
    start = np.interp(theta[-1] - 180.0 * halves, theta, time)
    return Turning(rate, 180.0 * halves / (time[-1] - start), float(turned))


def threshold_duration(rate: float, threshold: float, most: float) -> float:
    """Long enough for half a turn and some, or for coming to rest [s]."""
    if rate > 1.01 * threshold:
        return min(max(1.4 * 180.0 / math.sqrt(rate ** 2 - threshold ** 2), 20.0), most)
    return min(600.0 / threshold, most)


def threshold_of(points: list) -> dict:
    """Between the fastest rate at which the pattern comes to rest and the slowest that turns it. A
    run that creeps to its end is neither."""
    turning_points = [p for p in points if p.turned > 180.0]
    standing = [p.rate for p in points if p.turned <= 180.0 and abs(p.mean) < 0.01 * p.rate]
    slowest = min(turning_points, key=lambda p: p.rate, default=None)
    result = {"standing_deg_s": max(standing, default=math.nan),
              "turning_deg_s": slowest.rate if slowest else math.nan, "deg_s": math.nan}
    if slowest:
        # mean^2 = rate^2 - threshold^2 of the averaged model.
        result["deg_s"] = math.sqrt(max(slowest.rate ** 2 - slowest.mean ** 2, 0.0))
    return result


@dataclass
class Gain:
    frequency: float  # Hz
    gain: float       # measured angle over angle of the case
    delay: float      # s


def sine_amplitude(frequency: float) -> float:
    """Of the case's rate: 12 deg/s, or what makes one degree of angle [rad/s]."""
    return max(TWELVE, math.radians(1.0) * 2.0 * math.pi * frequency)


def sine_duration(frequency: float) -> float:
    return 2.0 + max(2.5, math.ceil(2.5 * frequency) / frequency if frequency > 1.0 else
                     (1.0 if frequency < 0.01 else 3.0) / frequency)


def angle_gain(run: Run, frequency: float) -> Gain:
    """Sine of the case's rate: A sin(2 pi f t), of its angle: -A / (2 pi f) cos(2 pi f t)."""
    loops = run.series("loops")
    time, theta = loops["time_s"], -loops["theta_deg"]
    chosen = time > 1.5
    time, theta = time[chosen], theta[chosen]
    periods = math.floor((time[-1] - time[0]) * frequency + 1e-6)
    chosen = time > time[-1] - max(periods, 1) / frequency
    time, theta = time[chosen], theta[chosen]
    angle = 2.0 * math.pi * frequency * time
    columns = [np.ones_like(time), np.cos(angle), np.sin(angle)]
    if periods >= 3:
        columns.append(time - time[0])
    fit = np.linalg.lstsq(np.stack(columns, axis=1), theta, rcond=None)[0]
    expected = math.degrees(sine_amplitude(frequency) / (2.0 * math.pi * frequency))
    response = complex(fit[1], -fit[2]) / -expected
    return Gain(frequency, abs(response), -np.angle(response) / (2.0 * math.pi * frequency))


@dataclass
class Sweep:
    """Response of both axes to their own drive, and what the tool printed."""
    frequency: np.ndarray
    x: np.ndarray
    y: np.ndarray
    split: float
    quality: float
    ks_peak: float
    ks_fit: float


def frequency_sweep(config: Path, folder: Path, points: int, voltages: dict) -> Sweep:
    folder.mkdir(parents=True, exist_ok=True)
    centre, span = 14194.5, 5.0  # Hz: tuning only softens
    overrides = [f"--set=resonator/{name}={value}" for name, value in voltages.items()]
    text = run_tool("frequency_response", "--config", config, "--csv", folder / "sweep.csv",
                    "--points", points, "--centre", centre, "--span", span, *overrides)
    sweep = Series(folder / "sweep.csv")
    lines = {line.split()[0]: line.split() for line in text.splitlines()
             if line.split() and line.split()[0] in ("f0", "ks")}
    split = next(float(line.split()[1]) for line in text.splitlines()
                 if line.strip().startswith("split"))
    return Sweep(sweep["frequency_hz"], sweep["xx_real"] + 1j * sweep["xx_imag"],
                 sweep["yy_real"] + 1j * sweep["yy_imag"], split,
                 quality=float(lines["f0"][4]), ks_peak=float(lines["ks"][7]),
                 ks_fit=float(lines["ks"][1]))


@dataclass
class Tuning:
    before: Sweep
    after: Sweep
    true_split: float   # of the ring after the last pass [Hz]


def mode_tuning(folder: Path, points: int) -> Tuning:
    config = find_config("untuned.yaml")
    folder.mkdir(parents=True, exist_ok=True)
    voltages_file = folder / "voltages.yaml"
    text = run_tool("tune_modes", "--config", config, "--output", voltages_file)
    voltages = yaml.safe_load(voltages_file.read_text())["resonator"]
    true_split = float(text.strip().splitlines()[-1].split()[-2])
    return Tuning(frequency_sweep(config, folder / "before", points, {}),
                  frequency_sweep(config, folder / "after", points, voltages), true_split)


CASES = {  # residual gamma that each case of the paper has; None: what the identification leaves
    "case1": None,
    "case2": (-0.016, 0.0),
    "case3": (0.0, 0.006),
    "case4": (0.0, 0.0),
}


@dataclass
class Results:
    simulation: Device
    experiment: Device
    settings: Settings
    derived: Run = None
    paper_tuning: Run = None
    identification: Run = None
    experiment_paper_tuning: Run = None
    tuning: Tuning = None
    tuning_missing: str = ""
    cases: dict = field(default_factory=dict)
    eight: dict = field(default_factory=dict)       # sign to (gamma2, run or None)
    steering: dict = field(default_factory=dict)    # rate to run
    thresholds: dict = field(default_factory=dict)  # name to list of Turning
    gains: dict = field(default_factory=dict)       # name to list of Gain
    group_delay: float = math.nan


def compensated(estimate: dict, target: tuple) -> dict:
    """Overrides that leave `target` of the mismatch that the identification found."""
    return {"calibration/gamma1": repr(estimate["gamma1"] - target[0]),
            "calibration/gamma2": repr(estimate["gamma2"] - target[1])}


def run_all(folder: Path, settings: Settings, progress_factory=Progress) -> Results:
    simulation = Device.preset("paper_simulation.yaml")
    experiment = Device.preset("paper_experiment.yaml")
    results = Results(simulation, experiment, settings)
    threshold = experiment.threshold(experiment.gamma)

    def run(device, name, duration, overrides=None):
        return lambda: simulate(device.config, folder / name, duration, overrides or {},
                                settings.keep_bags)

    def rotated(name, rate, overrides, limit):
        job = run(experiment, name, threshold_duration(rate, limit, settings.most_threshold),
                  {"control/virtual_rate": 0.0, "rotation/rate": math.radians(rate), **overrides})
        return lambda: turning(job(), rate)

    def shaken(name, frequency, overrides):
        # Without the pick-off, which makes the scale factor depend on the angle.
        job = run(experiment, name, sine_duration(frequency),
                  {"sense/cubic": 0.0, "control/virtual_rate": 0.0, "rotation/profile": "sine",
                   "rotation/frequency": repr(frequency),
                   "rotation/amplitude": repr(sine_amplitude(frequency)), **overrides})
        return lambda: angle_gain(job(), frequency)

    def steered(rate):
        mean = math.sqrt(rate ** 2 - threshold ** 2)
        duration = 360.0 * settings.steering_turns / mean
        return run(experiment, f"steering/{rate:g}", max(duration, 20.0),
                   {"control/virtual_rate": repr(math.radians(rate))})

    # What needs nothing but the presets; the longest first, so that both cores end together.
    paper = {"identification/tuning": "paper"}
    first = {
        "identification": run(experiment, "case1", settings.identification),
        "derived tuning": run(simulation, "section6/derived", settings.simulation),
        "paper's tuning": run(simulation, "section6/paper", settings.simulation, paper),
        "paper's tuning, section 7": run(experiment, "section7/paper", settings.simulation, paper),
        "mode tuning": lambda: mode_tuning(folder / "tuning", settings.sweep_points),
    }
    first.update({f"steering {rate:g} deg/s": steered(rate) for rate in settings.steering})
    for name, overrides in (("linear", {"sense/cubic": 0.0}), ("pick-off", {})):
        first.update({f"threshold, {name}, {rate:g} deg/s":
                      rotated(f"threshold/{name}/{rate:g}", rate, overrides, threshold)
                      for rate in settings.thresholds})
    first.update({f"bandwidth, uncompensated, {f:.4g} Hz":
                  shaken(f"bandwidth/uncompensated/{f:.4g}", f, {})
                  for f in settings.low_frequencies})

    after = len(CASES) - 1 + 2 + len(settings.low_thresholds) + len(settings.frequencies)
    progress = progress_factory(len(first) + after)
    done = run_jobs(first, settings.workers, progress)

    results.identification = done["identification"]
    results.derived = done["derived tuning"]
    results.paper_tuning = done["paper's tuning"]
    results.experiment_paper_tuning = done["paper's tuning, section 7"]
    results.tuning = done["mode tuning"]
    results.steering = {rate: done[f"steering {rate:g} deg/s"] for rate in settings.steering}
    for name in ("linear", "pick-off"):
        results.thresholds[name] = [done[f"threshold, {name}, {rate:g} deg/s"]
                                    for rate in settings.thresholds]
    results.gains["uncompensated"] = [done[f"bandwidth, uncompensated, {f:.4g} Hz"]
                                      for f in settings.low_frequencies]
    results.group_delay = results.identification.summary["settings"]["group_delay_s"]

    # What compensates the mismatch that the identification has found.
    estimate = final_estimate(results.identification)
    second = {name: run(experiment, name, settings.case,
                        compensated(estimate, target))
              for name, target in CASES.items() if target is not None}
    targets = {sign: gamma2_for(experiment, CASES["case2"][0], 8.0, results.identification.drift,
                                sign) for sign in (1, -1)}
    second.update({f"case 2, gamma2 {gamma2:+.4f}":
                   run(experiment, f"case2_gamma2_{gamma2:+.4f}", settings.case,
                       compensated(estimate, (CASES["case2"][0], gamma2)))
                   for gamma2 in targets.values()})
    nulled = compensated(estimate, (0.0, 0.0))
    limit = float(amplitudes(results.identification)[3])  # what compensation leaves
    second.update({f"threshold, compensated, {rate:g} deg/s":
                   rotated(f"threshold/compensated/{rate:g}", rate, nulled, limit)
                   for rate in settings.low_thresholds})
    second.update({f"bandwidth, {f:.4g} Hz": shaken(f"bandwidth/compensated/{f:.4g}", f, nulled)
                   for f in settings.frequencies})
    done = run_jobs(second, settings.workers, progress)
    progress.clear()

    results.cases = {"case1": results.identification,
                     **{name: done[name] for name in CASES if name != "case1"}}
    results.eight = {sign: (gamma2, done[f"case 2, gamma2 {gamma2:+.4f}"])
                     for sign, gamma2 in targets.items()}
    results.thresholds["compensated"] = [done[f"threshold, compensated, {rate:g} deg/s"]
                                         for rate in settings.low_thresholds]
    results.gains["compensated"] = [done[f"bandwidth, {f:.4g} Hz"] for f in settings.frequencies]
    return results
