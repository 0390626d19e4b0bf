#include "acpom.h"

#include "pom_c_types.h"

#include <stdlib.h>

#include "attitude.h"
#include "stamps.h"

/** An observer: it integrates the inertial unit, and draws the result to each pose with constant gains. */
struct pom_filter_s {
  bool known;        /* a pose and an inertial measurement have come */
  double pose_time;  /* s, of the last pose */
  double time;       /* s, of the estimate */
  or_time_ts ts;     /* the same */

  struct vec p, v, a;  /* world frame */
  struct quat q;
  struct vec w;  /* body frame */

  double pull;         /* rad/s, bandwidth of the corrections of position */
  double turn;         /* rad/s, of attitude */
  unsigned long idle;  /* periods without inertial measurement */
  unsigned long waits; /* periods of reset */
};

/** Seconds without pose or inertial measurement after which the state is unknown. */
static const double patience = .2;

static void
merge_imu(pom_filter_s *f, const quad_rotors_inertial *unit)
{
  double dt = clamp(seconds(unit->ts) - f->time, 0., .02);
  f->ts = unit->ts;
  f->time = seconds(unit->ts);
  f->idle = 0;
  f->w = (struct vec){unit->gyro.wx, unit->gyro.wy, unit->gyro.wz};
  if (!f->known) return;

  f->q = quat_unit(quat_times(f->q, quat_turn(vec_times(f->w, dt))));
  f->a = quat_rotate(f->q, (struct vec){unit->accel.ax, unit->accel.ay, unit->accel.az});
  f->a.z -= GRAVITY;
  f->p = vec_sum(f->p, vec_sum(vec_times(f->v, dt), vec_times(f->a, dt * dt / 2.)));
  f->v = vec_sum(f->v, vec_times(f->a, dt));
}

static void
merge_pose(pom_filter_s *f, const or_pose_estimator_state *pose)
{
  struct vec p = {pose->pos._value.x, pose->pos._value.y, pose->pos._value.z};
  struct quat q = {pose->att._value.qw, pose->att._value.qx, pose->att._value.qy, pose->att._value.qz};
  double now = seconds(pose->ts);
  double dt = clamp(now - f->pose_time, 0., .1);
  f->pose_time = now;

  if (!f->known) {
    if (f->time == 0.) return;
    f->p = p;
    f->q = quat_unit(q);
    f->v = f->a = (struct vec){0., 0., 0.};
    f->known = true;
    return;
  }

  /* The pose is older than the estimate: compare it with where the body was then. */
  double age = clamp(f->time - now, 0., .1);
  struct vec off = vec_sum(p, vec_times(vec_sum(f->p, vec_times(f->v, -age)), -1.));
  f->p = vec_sum(f->p, vec_times(off, clamp(2. * f->pull * dt, 0., 1.)));
  f->v = vec_sum(f->v, vec_times(off, clamp(f->pull * f->pull * dt, 0., 10.)));

  struct quat then = quat_times(f->q, quat_turn(vec_times(f->w, -age)));
  struct quat e = quat_times(quat_inverse(then), q);
  double k = (e.w < 0. ? -2. : 2.) * clamp(f->turn * dt, 0., 1.);
  f->q = quat_unit(quat_times(f->q, quat_turn((struct vec){k * e.x, k * e.y, k * e.z})));
}


/** Codel pom_filter_start of task filter.
 *
 * Triggered by pom_start.
 * Yields to pom_predict.
 */
genom_event
pom_filter_start(pom_filter_s **filter,
                 pom_ids_process_noise_s *process_noise,
                 const pom_state *state, const genom_context self)
{
  *filter = calloc(1, sizeof **filter);
  if (*filter) (*filter)->q.w = 1.;
  process_noise->jerk = 1000.;
  process_noise->angular_jerk = 1000.;

  or_pose_estimator_state *out = state->data(self);
  if (out) {
    out->pos._present = out->att._present = false;
    out->vel._present = out->avel._present = out->acc._present = false;
  }
  return pom_predict;
}


/** Codel pom_filter_predict of task filter.
 *
 * Triggered by pom_predict.
 * Yields to pom_correct.
 */
genom_event
pom_filter_predict(const pom_ids_process_noise_s *process_noise,
                   pom_filter_s **filter, const genom_context self)
{
  (void)self;
  pom_filter_s *f = *filter;
  if (!f) return pom_correct;
  /* The more the motion may change, the more a pose counts. */
  f->pull = cbrt(process_noise->jerk);
  f->turn = cbrt(process_noise->angular_jerk);
  f->idle++;
  f->waits++;
  return pom_correct;
}


/** Codel pom_filter_correct of task filter.
 *
 * Triggered by pom_correct.
 * Yields to pom_publish.
 */
genom_event
pom_filter_correct(sequence32_pom_input_s *inputs,
                   pom_filter_s **filter, const genom_context self)
{
  (void)self;
  for (uint32_t i = 0; *filter && i < inputs->_length; i++) {
    const pom_input_s *input = &inputs->_buffer[i];
    if (input->imu._present) merge_imu(*filter, &input->imu._value);
    if (input->pose._present) merge_pose(*filter, &input->pose._value);
  }
  inputs->_length = 0;
  return pom_publish;
}


/** Codel pom_filter_publish of task filter.
 *
 * Triggered by pom_publish.
 * Yields to pom_pause_predict.
 */
genom_event
pom_filter_publish(const pom_filter_s *filter, const pom_state *state,
                   const genom_context self)
{
  or_pose_estimator_state *out = state->data(self);
  if (!filter || !out || filter->time == 0.) return pom_pause_predict;

  bool known = filter->known && filter->time - filter->pose_time < patience &&
               filter->idle < patience / 1e-3;
  struct vec w = quat_rotate(filter->q, filter->w);
  out->ts = filter->ts;
  out->intrinsic = false;
  out->pos._present = out->att._present = out->vel._present = known;
  out->avel._present = out->acc._present = known;
  out->pos._value = (or_t3d_pos){filter->p.x, filter->p.y, filter->p.z};
  out->att._value = (or_t3d_att){filter->q.w, filter->q.x, filter->q.y, filter->q.z};
  out->vel._value = (or_t3d_vel){filter->v.x, filter->v.y, filter->v.z};
  out->avel._value = (or_t3d_avel){w.x, w.y, w.z};
  out->acc._value = (or_t3d_acc){filter->a.x, filter->a.y, filter->a.z};
  (void)state->write(self);
  return pom_pause_predict;
}


/** Codel pom_filter_stop of task filter.
 *
 * Triggered by pom_stop.
 * Yields to pom_ether.
 */
genom_event
pom_filter_stop(pom_filter_s **filter, const genom_context self)
{
  (void)self;
  free(*filter);
  *filter = NULL;
  return pom_ether;
}


/** Codel pom_reset_start of activity reset.
 *
 * Triggered by pom_start.
 * Yields to pom_pause_wait.
 * Throws pom_e_no_measure.
 */
genom_event
pom_reset_start(pom_filter_s **filter, const genom_context self)
{
  (void)self;
  if (*filter) {
    (*filter)->known = false;
    (*filter)->waits = 0;
  }
  return pom_pause_wait;
}


/** Codel pom_reset_wait of activity reset.
 *
 * Triggered by pom_wait.
 * Yields to pom_pause_wait, pom_ether.
 * Throws pom_e_no_measure.
 */
genom_event
pom_reset_wait(const pom_filter_s *filter, double timeout,
               const genom_context self)
{
  if (filter && filter->known) return pom_ether;
  if (!filter || filter->waits * 1e-3 > timeout) return pom_e_no_measure(self);
  return pom_pause_wait;
}


/** Codel pom_reset_stop of activity reset.
 *
 * Triggered by pom_stop.
 * Yields to pom_ether.
 * Throws pom_e_no_measure.
 */
genom_event
pom_reset_stop(pom_filter_s **filter, const genom_context self)
{
  (void)filter;
  (void)self;
  return pom_ether;
}
