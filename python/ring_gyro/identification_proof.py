"""Errors of the identifiers against bound and truth, as sections of a page."""

from pathlib import Path

from .tools import find_config, run_tool


def block(command: str, output: str) -> str:
    return f"    rosrun ring_gyro {command}\n\n```\n{output.rstrip()}\n```\n"


def at_the_bound(folder: Path, chosen) -> str:
    settings = [f"run/duration={chosen.duration:g}", "sense/cubic=0"]
    output = run_tool("identifier_efficiency", find_config("paper_experiment.yaml"), chosen.seeds,
                      *settings)
    return block(f"identifier_efficiency config/paper_experiment.yaml {chosen.seeds} "
                 + " ".join(settings), output)


def random_devices(folder: Path, chosen) -> str:
    lines = folder / "devices.jsonl"
    lines.unlink(missing_ok=True)
    run_tool("monte_carlo", "--config", find_config("paper_simulation.yaml"), "--random-devices",
             "--count", chosen.devices, "--output", lines)
    output = run_tool("monte_carlo", "--merge", lines)
    return block("monte_carlo --config config/paper_simulation.yaml --random-devices "
                 f"--count {chosen.devices} --output devices.jsonl; "
                 "rosrun ring_gyro monte_carlo --merge devices.jsonl", output)


def side_by_side(folder: Path, chosen) -> str:
    bags = []
    for seed in (1, 2):
        bag = folder / f"run_{seed}.bag"
        run_tool("simulate", "--config", find_config("paper_simulation.yaml"), "--duration", 120,
                 "--seed", seed, "--output", bag)
        bags.append(bag)
    output = run_tool("compare_identifiers", *bags, "--config",
                      find_config("paper_simulation.yaml"))
    for bag in bags:
        bag.unlink()
    return block("simulate --config config/paper_simulation.yaml --duration 120 --seed 1 --output "
                 "run_1.bag (and seed 2); rosrun ring_gyro compare_identifiers run_1.bag run_2.bag --config "
                 "config/paper_simulation.yaml", output.replace(str(folder) + "/", ""))


PARTS = (("at the bound", at_the_bound), ("random devices", random_devices),
         ("side by side", side_by_side))
