"""Drives the robot as start.tcl does: python3 drive.py, while `dotgen run class.scn --clock real` goes on."""

import dotgen

robot = dotgen.connect()
eye = robot.load("eye")
chase = robot.load("chase")

eye.set_swing(2)
chase.set_speed(0.3)
meeting = chase.meet(within=0.1, ack=True)
meeting.wait(timeout=20)
print("met")
print("speed", chase.get_speed(), "m/s")
try:
    chase.set_speed(-1)
except dotgen.Failed as error:
    print(error)
print("wheels", *chase.wheels())
chase.set_speed(0)
