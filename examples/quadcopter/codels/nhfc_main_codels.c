#include "acnhfc.h"

#include "nhfc_c_types.h"

#include <string.h>

#include "attitude.h"

enum { rotors = 4 };  /* front, left, back, right; front and back turn to the left */

static const double fastest = 100.;   /* Hz */
static const double steepest = .5;    /* tangent of the greatest tilt */
static const double reach = 1.;       /* m, greatest position error that counts */
static const double settled = .1;     /* m, position error below which it is integrated */
static const double tick = 1e-3;      /* s, the period */

static void
command(const double w[rotors], or_time_ts ts, const nhfc_cmd_velocity *cmd_velocity,
        const genom_context self)
{
  quad_rotors_velocities *out = cmd_velocity->data(self);
  if (!out) return;
  out->ts = ts;
  out->w._length = rotors;
  for (int i = 0; i < rotors; i++) out->w._buffer[i] = w[i];
  (void)cmd_velocity->write(self);
}

/** Returns the newest state, if it is known. */
static const or_pose_estimator_state *
known(const nhfc_state *state, const genom_context self)
{
  if (state->read(self) != genom_ok) return NULL;
  const or_pose_estimator_state *s = state->data(self);
  return s && s->pos._present && s->att._present && s->vel._present && s->avel._present ? s : NULL;
}

/** Makes the reference the place where the robot is, level and at rest. */
static void
stay(const or_pose_estimator_state *at, or_pose_estimator_state *reference)
{
  double yaw = quat_yaw((struct quat){
    at->att._value.qw, at->att._value.qx, at->att._value.qy, at->att._value.qz});
  struct quat q = quat_turn((struct vec){0., 0., yaw});
  memset(reference, 0, sizeof *reference);
  reference->ts = at->ts;
  reference->pos = at->pos;
  reference->att._present = true;
  reference->att._value = (or_t3d_att){q.w, q.x, q.y, q.z};
}


/** Codel hfc_main_start of task main.
 *
 * Triggered by nhfc_start.
 * Yields to nhfc_measure.
 */
genom_event
hfc_main_start(nhfc_ids_gains_s *gains, nhfc_ids_body_s *body,
               or_pose_estimator_state *reference,
               or_t3d_pos *integral,
               const nhfc_cmd_velocity *cmd_velocity,
               const genom_context self)
{
  /* Gains are forces and torques: N/m, N.s/m, N.m/rad, N.m.s/rad, N/(m.s). */
  *gains = (nhfc_ids_gains_s){
    .kp_xy = 2.5, .kp_z = 9., .kv_xy = 3.2, .kv_z = 6.,
    .kq_xy = 1., .kq_z = .3, .kw_xy = .22, .kw_z = .15,
    .ki_xy = .5, .ki_z = 2.};
  *body = (nhfc_ids_body_s){.mass = 1., .arm = .23, .thrust = 6.5e-4, .drag = 1e-5};
  memset(reference, 0, sizeof *reference);
  *integral = (or_t3d_pos){0., 0., 0.};
  command((double[rotors]){0.}, (or_time_ts){0, 0}, cmd_velocity, self);
  return nhfc_measure;
}


/** Codel hfc_main_measure of task main.
 *
 * Triggered by nhfc_measure.
 * Yields to nhfc_pause_measure, nhfc_control, nhfc_emergency.
 */
genom_event
hfc_main_measure(const nhfc_state *state, const genom_context self)
{
  if (known(state, self)) return nhfc_control;
  const or_pose_estimator_state *s = state->data(self);
  /* Nothing has come yet, or the state was known and is lost. */
  return s && (s->ts.sec || s->ts.nsec) ? nhfc_emergency : nhfc_pause_measure;
}


/** Codel hfc_main_control of task main.
 *
 * Triggered by nhfc_control.
 * Yields to nhfc_pause_measure.
 */
genom_event
hfc_main_control(const nhfc_ids_gains_s *gains,
                 const nhfc_ids_body_s *body, const nhfc_state *state,
                 const nhfc_actual_velocity *actual_velocity,
                 const or_pose_estimator_state *reference,
                 or_t3d_pos *integral,
                 const nhfc_cmd_velocity *cmd_velocity,
                 const genom_context self)
{
  (void)actual_velocity;
  const or_pose_estimator_state *s = state->data(self);
  const or_pose_estimator_state *r = reference;
  if (!s || !s->pos._present || !r->pos._present) {
    if (s) command((double[rotors]){0.}, s->ts, cmd_velocity, self);
    return nhfc_pause_measure;
  }

  /* Position: the force that reaches the reference. */
  struct vec e = {r->pos._value.x - s->pos._value.x, r->pos._value.y - s->pos._value.y,
                  r->pos._value.z - s->pos._value.z};
  struct vec ev = {-s->vel._value.vx, -s->vel._value.vy, -s->vel._value.vz};
  struct vec a = {0., 0., 0.};
  if (r->vel._present)
    ev = vec_sum(ev, (struct vec){r->vel._value.vx, r->vel._value.vy, r->vel._value.vz});
  if (r->acc._present) a = (struct vec){r->acc._value.ax, r->acc._value.ay, r->acc._value.az};
  if (vec_length(e) > reach) e = vec_times(e, reach / vec_length(e));

  /* The integral is for what stays: not for what is still far. */
  if (vec_length(e) < settled) {
    integral->x = clamp(integral->x + e.x * tick, -1., 1.);
    integral->y = clamp(integral->y + e.y * tick, -1., 1.);
    integral->z = clamp(integral->z + e.z * tick, -1., 1.);
  }

  struct vec f = {
    gains->kp_xy * e.x + gains->kv_xy * ev.x + gains->ki_xy * integral->x + body->mass * a.x,
    gains->kp_xy * e.y + gains->kv_xy * ev.y + gains->ki_xy * integral->y + body->mass * a.y,
    gains->kp_z * e.z + gains->kv_z * ev.z + gains->ki_z * integral->z +
      body->mass * (a.z + GRAVITY)};

  /* Near hovering: upwards, and tilted a little. */
  f.z = clamp(f.z, .3 * body->mass * GRAVITY, 2. * body->mass * GRAVITY);
  double side = hypot(f.x, f.y);
  if (side > steepest * f.z) {
    f.x *= steepest * f.z / side;
    f.y *= steepest * f.z / side;
  }

  /* Attitude: the body's vertical along the force, with the heading of the reference. */
  double yaw = 0.;
  if (r->att._present)
    yaw = quat_yaw((struct quat){
      r->att._value.qw, r->att._value.qx, r->att._value.qy, r->att._value.qz});
  struct vec z = vec_times(f, 1. / vec_length(f));
  struct quat tilt = quat_unit((struct quat){1. + z.z, -z.y, z.x, 0.});
  struct quat goal = quat_times(tilt, quat_turn((struct vec){0., 0., yaw}));
  struct quat q = {s->att._value.qw, s->att._value.qx, s->att._value.qy, s->att._value.qz};
  struct quat off = quat_times(quat_inverse(q), goal);
  double k = off.w < 0. ? -2. : 2.;
  struct vec w = quat_rotate(quat_inverse(q),
                             (struct vec){s->avel._value.wx, s->avel._value.wy, s->avel._value.wz});
  struct vec torque = {gains->kq_xy * k * off.x - gains->kw_xy * w.x,
                       gains->kq_xy * k * off.y - gains->kw_xy * w.y,
                       gains->kq_z * k * off.z - gains->kw_z * w.z};

  /* Wrench to propellers. */
  struct vec up = quat_rotate(q, (struct vec){0., 0., 1.});
  double sum = clamp(vec_dot(f, up), 0., 1e3) / body->thrust;
  double tx = torque.x / (body->arm * body->thrust), ty = torque.y / (body->arm * body->thrust);
  double tz = clamp(torque.z / body->drag, -.4 * sum, .4 * sum);
  const double squares[rotors] = {sum / 4. - ty / 2. - tz / 4., sum / 4. + tx / 2. + tz / 4.,
                                  sum / 4. + ty / 2. - tz / 4., sum / 4. - tx / 2. + tz / 4.};
  double speed[rotors];
  for (int i = 0; i < rotors; i++) speed[i] = sqrt(clamp(squares[i], 0., fastest * fastest));
  command(speed, s->ts, cmd_velocity, self);
  return nhfc_pause_measure;
}


/** Codel hfc_main_emergency of task main.
 *
 * Triggered by nhfc_emergency.
 * Yields to nhfc_pause_measure, nhfc_pause_emergency.
 */
genom_event
hfc_main_emergency(const nhfc_ids_body_s *body,
                   const nhfc_actual_velocity *actual_velocity,
                   const nhfc_cmd_velocity *cmd_velocity,
                   const genom_context self)
{
  /* A little less than hovering, if the propellers turn; blind, there is nothing to steer by. */
  const quad_rotors_velocities *actual = NULL;
  if (actual_velocity->read(self) == genom_ok) actual = actual_velocity->data(self);
  double all = sqrt(.9 * body->mass * GRAVITY / (rotors * body->thrust));
  double speed[rotors];
  for (int i = 0; i < rotors; i++)
    speed[i] = actual && actual->w._length > (uint32_t)i && actual->w._buffer[i] > all / 2. ? all : 0.;
  command(speed, actual ? actual->ts : (or_time_ts){0, 0}, cmd_velocity, self);
  return nhfc_pause_measure;
}


/** Codel hfc_main_stop of task main.
 *
 * Triggered by nhfc_stop.
 * Yields to nhfc_ether.
 */
genom_event
hfc_main_stop(const nhfc_cmd_velocity *cmd_velocity,
              const genom_context self)
{
  command((double[rotors]){0.}, (or_time_ts){0, 0}, cmd_velocity, self);
  return nhfc_ether;
}


/** Codel hfc_servo_start of activity servo.
 *
 * Triggered by nhfc_start.
 * Yields to nhfc_track.
 * Throws nhfc_e_no_state.
 */
genom_event
hfc_servo_start(const nhfc_state *state,
                or_pose_estimator_state *reference,
                const genom_context self)
{
  const or_pose_estimator_state *s = known(state, self);
  if (!s) return nhfc_e_no_state(self);
  stay(s, reference);
  return nhfc_track;
}


/** Codel hfc_servo_track of activity servo.
 *
 * Triggered by nhfc_track.
 * Yields to nhfc_pause_track.
 * Throws nhfc_e_no_state.
 */
genom_event
hfc_servo_track(const nhfc_desired *desired,
                or_pose_estimator_state *reference,
                const genom_context self)
{
  if (desired->read(self) == genom_ok) {
    const or_pose_estimator_state *d = desired->data(self);
    if (d && d->pos._present) *reference = *d;
  }
  return nhfc_pause_track;
}


/** Codel hfc_servo_stop of activity servo.
 *
 * Triggered by nhfc_stop.
 * Yields to nhfc_ether.
 * Throws nhfc_e_no_state.
 */
genom_event
hfc_servo_stop(or_pose_estimator_state *reference,
               const genom_context self)
{
  (void)self;
  /* Stay at the last place: without its velocity. */
  reference->vel._present = reference->avel._present = reference->acc._present = false;
  return nhfc_ether;
}


/** Codel hfc_hold_start of activity hold.
 *
 * Triggered by nhfc_start.
 * Yields to nhfc_ether.
 * Throws nhfc_e_no_state.
 */
genom_event
hfc_hold_start(const nhfc_state *state,
               or_pose_estimator_state *reference,
               or_t3d_pos *integral, const genom_context self)
{
  const or_pose_estimator_state *s = known(state, self);
  if (!s) return nhfc_e_no_state(self);
  stay(s, reference);
  *integral = (or_t3d_pos){0., 0., 0.};
  return nhfc_ether;
}
