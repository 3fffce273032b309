"""A stand-in for glenoid-bridge: states, token and feedback as lcm_types/CHANNELS.md says, joints that follow at once."""

import threading
import time

import lcm
from glenoid.devices import JOINTS
from glenoid.lcm_types import command_v1_t, device_v1_t, event_v1_t, feedback_v1_t, setpoint_v1_t, status_v1_t
from glenoid.publisher import COMMAND, DEVICE, EVENT, FEEDBACK, SETPOINT, STATUS, now_ns

PERIOD_S = 0.004


def padded(text, size):
    """A text as messages carry it."""
    return [*text.encode(), *[0] * (size - len(text.encode()))]


def device_message(joints=JOINTS, side=device_v1_t.RIGHT, limit_rad=100.0, device="", device_sha256=""):
    """What a bridge says that it drives; joints all with the same limits."""
    told = device_v1_t()
    told.exoskeleton, told.device = padded("stand_in", 32), padded(device, 32)
    told.device_sha256, told.side, told.joint_count = padded(device_sha256, 64), side, len(joints)
    told.joint_name = [padded(name, 32) for name in (*joints, *[""] * (16 - len(joints)))]
    told.lower_rad, told.upper_rad = [-limit_rad] * 16, [limit_rad] * 16
    return told


class Bridge:
    """Runs in a thread between `with`; what it accepted is in `setpoints`."""

    def __init__(
        self, url, start_rad, real_bus_mask=0, speed_limit=2.0, refuse_arming=None, stop_after=None, device=None
    ):
        self.position = list(start_rad)
        self.device = device or device_message(JOINTS[: len(self.position)])
        self.setpoints = []
        self.commands = []
        self.state, self.session, self.sequence = status_v1_t.IDLE, 0, 0
        self.real_bus_mask, self.speed_limit = real_bus_mask, speed_limit
        self.refuse_arming, self.stop_after = refuse_arming, stop_after
        self._lcm = lcm.LCM(url)
        self._lcm.subscribe(SETPOINT, self.on_setpoint)
        self._lcm.subscribe(COMMAND, self.on_command)
        self._end = threading.Event()
        self._thread = threading.Thread(target=self.run)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._end.set()
        self._thread.join()

    def on_setpoint(self, _, data):
        setpoint = setpoint_v1_t.decode(data)
        if setpoint.session != self.session or self.session == 0:
            return
        self.setpoints.append(setpoint)
        self.position = list(setpoint.position_rad[: len(self.position)])
        if self.stop_after is not None and len(self.setpoints) == self.stop_after:
            self.state = status_v1_t.FAULT
            self.say("something broke")

    def on_command(self, _, data):
        command = command_v1_t.decode(data)
        self.commands.append(command.command)
        if command.command == command_v1_t.ARM and self.state == status_v1_t.IDLE:
            if self.refuse_arming:
                self.say(self.refuse_arming)
            else:
                self.state, self.session = status_v1_t.READY, 4711
        elif command.session != self.session:
            self.say("token of another session")
        elif command.command == command_v1_t.START and self.setpoints:
            self.state = status_v1_t.RUN
        elif command.command == command_v1_t.DISARM:
            self.state, self.session = status_v1_t.IDLE, 0

    def say(self, text):
        event = event_v1_t()
        event.severity = event_v1_t.WARNING
        event.text = [*text.encode(), *[0] * (160 - len(text))]
        self._lcm.publish(EVENT, event.encode())

    def run(self):
        n = len(self.position)
        while not self._end.is_set():
            while self._lcm.handle_timeout(0) > 0:
                pass
            self.sequence += 1
            feedback = feedback_v1_t()
            feedback.time_mono_ns, feedback.sequence, feedback.session = now_ns(), self.sequence, self.session
            feedback.count, feedback.valid_mask, feedback.state = n, (1 << n) - 1, self.state
            feedback.position_rad = [*self.position, *[0.0] * (16 - n)]
            self._lcm.publish(FEEDBACK, feedback.encode())
            status = status_v1_t()
            status.state, status.session, status.joint_count = self.state, self.session, n
            status.real_bus_mask = self.real_bus_mask
            status.fault = 6 if self.state == status_v1_t.FAULT else 0
            status.velocity_limit_rad_per_s = [self.speed_limit] * 16
            status.acceleration_limit_rad_per_s2 = [20.0] * 16
            self._lcm.publish(STATUS, status.encode())
            self._lcm.publish(DEVICE, self.device.encode())
            time.sleep(PERIOD_S)
