"""From checked inputs to the settings of the core."""

from __future__ import annotations

import numpy as np

from glenoid import _core
from glenoid.inputs import InputError, ReachInput, RhythmInput, SubjectInput

SUBJECT_FIELDS = (
    "stature_m",
    "mass_kg",
    "upper_arm_length_m",
    "forearm_length_m",
    "shoulder_distance_m",
    "upper_arm_mass_kg",
    "forearm_mass_kg",
    "upper_arm_com_m",
    "forearm_com_m",
    "upper_arm_inertia_kg_m2",
    "forearm_inertia_kg_m2",
)


def core_subject(subject: SubjectInput) -> _core.Subject:
    """The subject as the core takes it."""
    out = _core.Subject()
    for field in SUBJECT_FIELDS:
        value = getattr(subject, field)
        setattr(out, field, np.array(value) if isinstance(value, tuple) else value)
    out.female = subject.sex == "female"
    out.left_arm = subject.arm == "left"
    return out


def core_limits(subject: SubjectInput) -> _core.JointLimits:
    """Joint limits, rad."""
    lower, upper = subject.limits_deg.as_rad()
    limits = _core.JointLimits()
    limits.lower_rad = np.array(lower)
    limits.upper_rad = np.array(upper)
    return limits


def check_subject(subject: SubjectInput) -> None:
    """InputError with the core's own words if it refuses the person's figures or limits."""
    try:
        scaled = _core.scale_subject(core_subject(subject))
        rhythm = _core.Rhythm(core_rhythm(RhythmInput()), scaled.shoulder_distance_m)
        _core.make_arm_model(scaled, rhythm, core_limits(subject), True)
    except ValueError as error:
        raise InputError(str(error)) from error


def core_rhythm(rhythm: RhythmInput) -> _core.RhythmSettings:
    """Rhythm settings."""
    out = _core.RhythmSettings()
    out.model = getattr(_core.RhythmModel, rhythm.model)
    out.gain = rhythm.gain
    out.smoothing_rad = rhythm.smoothing_rad
    if rhythm.measured is not None:
        out.measured = _core.MeasuredRhythm()
        out.measured.slope_m = list(rhythm.measured.slope_m)
        out.measured.shoulder_distance_m = rhythm.measured.shoulder_distance_m
    return out


def core_prior(reach: ReachInput) -> _core.PosturePriorCoefficients:
    """Coefficients of the posture prior: the core's own where none are given."""
    out = _core.PosturePriorCoefficients()
    if reach.swivel.prior is not None:
        for name, value in reach.swivel.prior.model_dump().items():
            setattr(out, name, value)
    return out


def with_axial_factor(scaled: _core.ScaledArm, reach: ReachInput) -> _core.ScaledArm:
    """Makes turning dearer in the metric, in place, as the core does for its own generator (M5, M6)."""
    mode = getattr(_core.SwivelMode, reach.swivel.mode)
    _core.apply_axial_factor(scaled, _core.effective_axial_factor(reach.axial_factor or 0.0, mode))
    return scaled


def core_motion(reach: ReachInput, exo: _core.ExoSettings | None = None) -> _core.MotionSettings:
    """Everything that the generator needs before the first movement; without a device, the core's own default one."""
    settings = _core.MotionSettings()
    settings.subject = core_subject(reach.subject)
    settings.rhythm = core_rhythm(reach.rhythm)
    settings.limits = core_limits(reach.subject)
    settings.moving_shoulder = reach.metric == "movingShoulder"
    settings.swivel_mode = getattr(_core.SwivelMode, reach.swivel.mode)
    settings.swivel_prescribed_rad = reach.swivel.prescribed_rad
    settings.posture_prior = core_prior(reach)
    settings.axial_factor = reach.axial_factor or 0.0
    settings.timing = getattr(_core.TimingLaw, reach.timing)
    settings.duration_s = reach.duration_s
    settings.start_q_rad = np.array(reach.start_rad)
    if reach.start_shoulder_m is not None:
        settings.shoulder_start_m = np.array(reach.start_shoulder_m)
    if exo is not None:
        settings.exo = exo
    return settings


def mirrored_if_left(points_m: np.ndarray, subject: SubjectInput) -> np.ndarray:
    """Points (..., 3) of the arm's own side: the core's arm models are right arms, a left arm is their mirror image."""
    return points_m * np.array([-1.0, 1.0, 1.0]) if subject.arm == "left" else points_m


def make_generator(reach: ReachInput, exo: _core.ExoSettings | None = None) -> _core.MotionGenerator:
    """The generator at time 0, at rest in the start posture. InputError with the core's own words if it refuses."""
    try:
        return _core.MotionGenerator(core_motion(reach, exo), 0.0)
    except ValueError as error:
        raise InputError(str(error)) from error
