"""The options that make simulators can be sent to another process."""

import pickle

import radar_service as rs
from radar_service.commands.simulator_options import SimulatorOptions
from radar_service.plan.budget import ErrorBudget

SCENE = {"radar": {"azimuths": 60, "beamwidth_deg": 8, "range_max_m": 600}}


def test_options_reach_the_simulator() -> None:
    options = SimulatorOptions(fidelity="fast", seed=3)
    simulator = pickle.loads(pickle.dumps(options))(rs.load_scene(SCENE))
    assert (simulator.fidelity.name, simulator.seed) == ("fast", 3) and "plan" not in vars(
        simulator
    )  # it costs as much as the rest


def test_labels_are_asked_for_by_an_option() -> None:
    made = rs.load_scene(SCENE)
    assert SimulatorOptions(labels=True)(made).scan().labels is not None
    assert SimulatorOptions()(made).scan().labels is None


def test_an_error_budget_comes_before_a_preset() -> None:
    fine, coarse = (SimulatorOptions(error_db=ErrorBudget(db))(rs.load_scene(SCENE)).fidelity for db in (0.05, 3.0))
    assert fine != coarse
