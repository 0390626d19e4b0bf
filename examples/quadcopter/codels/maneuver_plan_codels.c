#include "acmaneuver.h"

#include "maneuver_c_types.h"

#include <string.h>

#include "attitude.h"

static const double step = 5e-3;    /* s, the period of task exec */
static const double ground = 1e-2;  /* m, altitude to land at */

/** Returns the time of the sample that follows another. */
static or_time_ts
after(or_time_ts ts)
{
  ts.nsec += (uint32_t)(step * 1e9);
  if (ts.nsec >= 1000000000) {
    ts.nsec -= 1000000000;
    ts.sec++;
  }
  return ts;
}

/** Appends a motion from rest to rest, along a line, with the least jerk. Returns where it ends. */
static struct vec
append_line(const maneuver_planner_s *planner, or_time_ts *now, struct vec from, struct vec to,
            double yaw0, double yaw1, maneuver_path_s *path)
{
  struct vec d = vec_sum(to, vec_times(from, -1.));
  double length = vec_length(d), angle = fabs(yaw1 - yaw0);

  /* Greatest velocity 15/8 of the mean one, greatest acceleration 10/sqrt(3) of length / time^2. */
  double time = 15. / 8. * fmax(length / planner->vmax, angle / planner->wmax);
  time = fmax(time, sqrt(10. / sqrt(3.) * fmax(length / planner->amax, angle / planner->dwmax)));
  int samples = (int)ceil(time / step);

  for (int i = 1; i <= samples && path->_length < maneuver_max_samples; i++) {
    double t = (double)i / samples, T = samples * step;
    double s = t * t * t * (10. - t * (15. - 6. * t));
    double v = t * t * (30. - t * (60. - 30. * t)) / T;
    double a = t * (60. - t * (180. - 120. * t)) / (T * T);
    struct vec p = vec_sum(from, vec_times(d, s));
    struct quat q = quat_turn((struct vec){0., 0., yaw0 + (yaw1 - yaw0) * s});

    or_pose_estimator_state *out = &path->_buffer[path->_length++];
    memset(out, 0, sizeof *out);
    out->ts = *now = after(*now);
    out->pos._present = out->att._present = true;
    out->vel._present = out->avel._present = out->acc._present = true;
    out->pos._value = (or_t3d_pos){p.x, p.y, p.z};
    out->att._value = (or_t3d_att){q.w, q.x, q.y, q.z};
    out->vel._value = (or_t3d_vel){d.x * v, d.y * v, d.z * v};
    out->avel._value = (or_t3d_avel){0., 0., (yaw1 - yaw0) * v};
    out->acc._value = (or_t3d_acc){d.x * a, d.y * a, d.z * a};
  }
  return to;
}

/** Plans a motion from a state to a point, or none if the state is not known. */
static void
plan_to(const maneuver_planner_s *planner, const or_pose_estimator_state *start, struct vec to,
        double yaw, maneuver_path_s *path)
{
  struct vec from = {start->pos._value.x, start->pos._value.y, start->pos._value.z};
  double yaw0 = quat_yaw((struct quat){start->att._value.qw, start->att._value.qx,
                                       start->att._value.qy, start->att._value.qz});
  double yaw1 = yaw0 + remainder(yaw - yaw0, 2. * M_PI);
  or_time_ts now = start->ts;
  path->_length = 0;
  if (!start->pos._present || !start->att._present) return;

  /* Below the lowest altitude it goes up and down only: take-off and landing. */
  if (hypot(to.x - from.x, to.y - from.y) > .05) {
    if (from.z < planner->zmin) {
      struct vec above = {from.x, from.y, planner->zmin};
      from = append_line(planner, &now, from, above, yaw0, yaw0, path);
    }
    if (to.z < planner->zmin) {
      struct vec above = {to.x, to.y, planner->zmin};
      from = append_line(planner, &now, from, above, yaw0, yaw1, path);
      yaw0 = yaw1;
    }
  }
  append_line(planner, &now, from, to, yaw0, yaw1, path);
}


/* --- Task plan -------------------------------------------------------- */


/** Codel mv_plan_start of task plan.
 *
 * Triggered by maneuver_start.
 * Yields to maneuver_ether.
 */
genom_event
mv_plan_start(maneuver_ids *ids, const genom_context self)
{
  (void)self;
  ids->planner = (maneuver_planner_s){.vmax = 1., .wmax = 1., .amax = .8, .dwmax = 2., .zmin = .5};
  ids->trajectory.samples._length = ids->trajectory.current = 0;
  ids->trajectory.running = false;
  ids->tour.points._length = ids->tour.visited = 0;
  return maneuver_ether;
}


/** Codel mv_plan_stop of task plan.
 *
 * Triggered by maneuver_stop.
 * Yields to maneuver_ether.
 */
genom_event
mv_plan_stop(maneuver_ids *ids, const genom_context self)
{
  (void)self;
  ids->trajectory.running = false;
  return maneuver_ether;
}


/* --- Activity goto ---------------------------------------------------- */

/** Codel mv_current_state_start of activity goto.
 *
 * Triggered by maneuver_start.
 * Yields to maneuver_plan.
 * Throws maneuver_e_nostate.
 */
genom_event
mv_current_state_start(const maneuver_state *state,
                       or_pose_estimator_state *start,
                       const genom_context self)
{
  if (state->read(self) != genom_ok) return maneuver_e_nostate(self);
  const or_pose_estimator_state *s = state->data(self);
  if (!s || !s->pos._present || !s->att._present) return maneuver_e_nostate(self);
  *start = *s;
  return maneuver_plan;
}

/** Codel mv_goto_plan of activity goto.
 *
 * Triggered by maneuver_plan.
 * Yields to maneuver_exec.
 * Throws maneuver_e_nostate.
 */
genom_event
mv_goto_plan(const maneuver_planner_s *planner,
             const or_pose_estimator_state *start, double x, double y,
             double z, double yaw, maneuver_path_s *path,
             const genom_context self)
{
  (void)self;
  plan_to(planner, start, (struct vec){x, y, z}, yaw, path);
  return maneuver_exec;
}

/** Codel mv_plan_exec of activity goto.
 *
 * Triggered by maneuver_exec.
 * Yields to maneuver_wait.
 * Throws maneuver_e_nostate.
 */
genom_event
mv_plan_exec(const maneuver_planner_s *planner,
             const maneuver_path_s *path,
             maneuver_ids_trajectory_s *trajectory,
             const genom_context self)
{
  (void)planner;
  (void)self;
  trajectory->samples._length = path->_length;
  memcpy(trajectory->samples._buffer, path->_buffer, path->_length * sizeof *path->_buffer);
  trajectory->current = 0;
  trajectory->running = true;
  return maneuver_wait;
}

/** Codel mv_plan_exec_wait of activity goto.
 *
 * Triggered by maneuver_wait.
 * Yields to maneuver_pause_wait, maneuver_ether.
 * Throws maneuver_e_nostate.
 */
genom_event
mv_plan_exec_wait(const maneuver_ids_trajectory_s *trajectory,
                  const genom_context self)
{
  (void)self;
  return trajectory->running ? maneuver_pause_wait : maneuver_ether;
}

/** Codel mv_plan_exec_stop of activity goto.
 *
 * Triggered by maneuver_stop.
 * Yields to maneuver_ether.
 * Throws maneuver_e_nostate.
 */
genom_event
mv_plan_exec_stop(maneuver_ids_trajectory_s *trajectory,
                  const genom_context self)
{
  (void)self;
  trajectory->running = false;
  return maneuver_ether;
}


/* --- Activity next ---------------------------------------------------- */

/** Codel mv_next_plan of activity next.
 *
 * Triggered by maneuver_plan.
 * Yields to maneuver_exec.
 * Throws maneuver_e_nostate, maneuver_e_end.
 */
genom_event
mv_next_plan(const maneuver_planner_s *planner,
             const or_pose_estimator_state *start,
             maneuver_ids_tour_s *tour, maneuver_path_s *path,
             const genom_context self)
{
  if (tour->visited >= tour->points._length) return maneuver_e_end(self);
  const maneuver_point_s *p = &tour->points._buffer[tour->visited++];
  plan_to(planner, start, (struct vec){p->x, p->y, p->z}, p->yaw, path);
  return maneuver_exec;
}


/* --- Activity land ---------------------------------------------------- */

/** Codel mv_land_plan of activity land.
 *
 * Triggered by maneuver_plan.
 * Yields to maneuver_exec.
 * Throws maneuver_e_nostate.
 */
genom_event
mv_land_plan(const maneuver_planner_s *planner,
             const or_pose_estimator_state *start,
             maneuver_path_s *path, const genom_context self)
{
  (void)self;
  const or_t3d_pos *p = &start->pos._value;
  const or_t3d_att *q = &start->att._value;
  double yaw = quat_yaw((struct quat){q->qw, q->qx, q->qy, q->qz});
  plan_to(planner, start, (struct vec){p->x, p->y, ground}, yaw, path);
  return maneuver_exec;
}


/* --- Activity waypoint ------------------------------------------------ */

/** Codel mv_waypoint_start of activity waypoint.
 *
 * Triggered by maneuver_start.
 * Yields to maneuver_plan.
 */
genom_event
mv_waypoint_start(const maneuver_state *state,
                  const maneuver_ids_trajectory_s *trajectory,
                  or_pose_estimator_state *start,
                  const genom_context self)
{
  if (trajectory->running && trajectory->samples._length) {
    *start = trajectory->samples._buffer[trajectory->samples._length - 1];
    return maneuver_plan;
  }
  /* Without a state, the plan is empty: this activity throws nothing. */
  const or_pose_estimator_state *s = NULL;
  if (state->read(self) == genom_ok) s = state->data(self);
  memset(start, 0, sizeof *start);
  if (s) *start = *s;
  return maneuver_plan;
}

/** Codel mv_goto_plan of activity waypoint.
 *
 * Triggered by maneuver_plan.
 * Yields to maneuver_exec.
 */
/* already defined in service goto */


/** Codel mv_waypoint_add of activity waypoint.
 *
 * Triggered by maneuver_exec.
 * Yields to maneuver_ether.
 */
genom_event
mv_waypoint_add(const maneuver_planner_s *planner,
                const maneuver_path_s *path,
                maneuver_ids_trajectory_s *trajectory,
                const genom_context self)
{
  (void)planner;
  (void)self;
  maneuver_path_s *all = &trajectory->samples;
  if (!trajectory->running) all->_length = trajectory->current = 0;

  /* Room for it: samples that were tracked go. */
  all->_length -= trajectory->current;
  memmove(all->_buffer, all->_buffer + trajectory->current, all->_length * sizeof *all->_buffer);
  trajectory->current = 0;

  uint32_t room = maneuver_max_samples - all->_length;
  uint32_t more = path->_length < room ? path->_length : room;
  memcpy(all->_buffer + all->_length, path->_buffer, more * sizeof *all->_buffer);
  all->_length += more;
  trajectory->running = all->_length > 0;
  return maneuver_ether;
}
