"""A rehearsal in virtual time: bridge core and drive models in lock-step, deterministic."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from glenoid import _core
from glenoid.inputs import InputError
from glenoid.lcm_types import command_v1_t
from glenoid.publisher import STATES
from glenoid.rehearse.load import arm_load
from glenoid.rehearse.motion import Motion
from glenoid.rehearse.record import STATE_NUMBER, Record
from glenoid.rehearse.scenario import FaultInput, Scenario
from glenoid.rehearse.stream import LEAD_S, Stream, make_stream, with_faults

PROFILES = Path(__file__).absolute().parents[1] / "data" / "drives" / "profiles"
START_UP_S, ENABLE_S, DISARM_S = 10.0, 3.0, 3.0
#: after a stop is latched the run goes on so long, to see the drives come to rest and lose their power
AFTER_STOP_S = 1.0
#: cycles between two reports of progress
CHUNK = 250
#: faults of a drive model by the scenario's word
DRIVE_FAULTS = {
    "drive_emcy": "emcy",
    "drive_vanish": "stall",
    "drive_reboot": "reboot",
    "drive_stuck_encoder": "stuck-encoder",
    "drive_jam": "jam",
    "drive_drop": "drop",
    "drive_delay": "delay",
    "drive_bus_off": "bus-off",
}
OTHERS = {
    "drive_heartbeat_lost": "drive-heartbeat",
    "master_heartbeat_lost": "master-heartbeat",
    "estop": "estop",
    "estop_input": "estop-input",
    "bus_silent": "bus-silent",
    "bus_stalled": "bus-stalled",
    "link_down": "link-down",
}


def profile_file(scenario: Scenario) -> Path:
    """File of the drives' profile: a name of a shipped one, or a file. InputError if there is none."""
    name = scenario.data.drives.profile
    path = scenario.near(name) if name.endswith((".yaml", ".yml")) else PROFILES / f"{name}.yaml"
    if not path.is_file():
        known = ", ".join(sorted(p.stem for p in PROFILES.glob("*.yaml")))
        raise InputError(f"{scenario.path}: drives.profile = {name!r}: must be a YAML file or one of {known}")
    return path


def make_rig(scenario: Scenario, motion: Motion) -> _core.Rig:
    """The rig with its drives where the motion begins."""
    joints = len(scenario.joints)
    start = motion.samples["exo_q_rad"][0]
    if len(start) != joints:
        raise InputError(f"{scenario.bridge_file}: {joints} joints, the exoskeleton has {len(start)}")
    try:
        return _core.Rig(
            scenario.config,
            [str(profile_file(scenario))] * joints,
            start.tolist(),
            scenario.data.drives.seed,
            arm_load(scenario, motion),
        )
    except ValueError as error:
        raise InputError(f"{scenario.bridge_file}: {error}") from error


def schedule(rig: _core.Rig, fault: FaultInput, origin_ns: int, joints: list[str]) -> None:
    """Hands a fault that is not one of the stream to the rig."""
    kind = "drive" if fault.kind in DRIVE_FAULTS else OTHERS.get(fault.kind)
    if kind is None:
        return
    amount = fault.figure * (1000.0 if fault.kind == "drive_delay" else 1.0)
    rig.schedule(
        kind,
        origin_ns + round(1e9 * fault.at_s),
        round(1e9 * (fault.duration_s or 0.0)),
        joints.index(fault.joint) if fault.joint is not None else -1,
        0,
        DRIVE_FAULTS.get(fault.kind, "none"),
        round(amount),
    )


def play(rig: _core.Rig, stream: Stream, origin_ns: int) -> None:
    """Hands the stream to the rig."""
    rig.play(
        stream.due_ns + origin_ns,
        stream.stamp_ns + origin_ns,
        stream.sequence,
        stream.session_xor,
        stream.position_rad,
        stream.velocity_rad_per_s,
    )


def run_virtual(
    scenario: Scenario, motion: Motion, tell: Callable[[str, float], None] = lambda _what, _share: None
) -> Record:
    """Start-up, arming, the movements, disarming.

    Args:
        scenario: what to do.
        motion: of the source, a sample every setpoint period.
        tell: is told the stage and its share done.

    Raises:
        InputError: profile, configuration and device do not fit together.

    """
    config, rig = scenario.config, make_rig(scenario, motion)
    stages: list[str] = []

    def cycles(seconds: float) -> int:
        return round(seconds * 1e9 / config.period_ns)

    def finish(origin_ns: int) -> Record:
        return record_of(rig, origin_ns, stages)

    tell("start-up of the drives", 0.0)
    if not rig.configure(cycles(START_UP_S)):
        stages.append("not every drive was configured and operational")
        return finish(rig.now_ns)
    rig.run(5)
    rig.request(command_v1_t.ARM)
    if not rig.run_until(STATE_NUMBER["READY"], cycles(ENABLE_S)):
        stages.append("the drives were not enabled")
        return finish(rig.now_ns)
    origin_ns = rig.now_ns + round(1e9 * LEAD_S)
    stream = with_faults(make_stream(motion, config.setpoint_period_ns), scenario.data.faults, scenario.joints)
    play(rig, stream, origin_ns)
    for fault in scenario.data.faults:
        schedule(rig, fault, origin_ns, scenario.joints)
    rig.run(cycles(0.25 * LEAD_S))
    rig.request(command_v1_t.START)
    follow(rig, origin_ns, motion, stages, cycles, tell)
    return finish(origin_ns)


def follow(
    rig: _core.Rig,
    origin_ns: int,
    motion: Motion,
    stages: list[str],
    cycles: Callable[[float], int],
    tell: Callable[[str, float], None],
) -> None:
    """From the start to the end of the motion, or until what a stop leads to was seen; then disarms."""
    if not rig.run_until(STATE_NUMBER["RUN"], cycles(0.5 * LEAD_S)):
        stages.append("the bridge did not start to follow")
    length_ns = round(1e9 * (motion.rows * motion.period_s))
    end_ns = origin_ns + length_ns + round(0.2e9)
    stopped = (STATE_NUMBER["STOP"], STATE_NUMBER["FAULT"])
    while rig.now_ns < end_ns:
        if rig.state in stopped:
            rig.run(cycles(AFTER_STOP_S))
            return
        rig.run(min(CHUNK, max(1, cycles(1e-9 * (end_ns - rig.now_ns)))))
        tell("movements", min(1.0, max(0.0, (rig.now_ns - origin_ns) / (end_ns - origin_ns))))
    if rig.state in stopped:
        rig.run(cycles(AFTER_STOP_S))
        return
    rig.request(command_v1_t.DISARM)
    if not rig.run_until(STATE_NUMBER["IDLE"], cycles(DISARM_S)):
        stages.append("the bridge did not come to rest and disarm")
        return
    rig.run(cycles(0.1))


def record_of(rig: _core.Rig, origin_ns: int, stages: list[str]) -> Record:
    """What the rig recorded."""
    return Record(
        origin_ns=origin_ns,
        feedback=rig.feedback(),
        setpoints=rig.setpoints(),
        commands=rig.commands(),
        frames=rig.frames(),
        events=rig.events(),
        statuses=rig.statuses(),
        truth=rig.cycles(),
        drives=rig.drives(),
        stages=stages,
        state=STATES[rig.state],
        fault=rig.fault,
    )
