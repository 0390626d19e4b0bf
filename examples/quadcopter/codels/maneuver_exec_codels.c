#include "acmaneuver.h"

#include "maneuver_c_types.h"

#include "stamps.h"

/* The last state that was seen, for function stop. */
or_t3d_pos mv_last;

/** Returns the newest state, if it is known. */
static const or_pose_estimator_state *
known(const maneuver_state *state, const genom_context self)
{
  if (state->read(self) != genom_ok) return NULL;
  const or_pose_estimator_state *s = state->data(self);
  if (!s || !s->pos._present) return NULL;
  mv_last = s->pos._value;
  return s;
}


/* --- Task exec -------------------------------------------------------- */


/** Codel mv_exec_start of task exec.
 *
 * Triggered by maneuver_start.
 * Yields to maneuver_wait.
 */
genom_event
mv_exec_start(const maneuver_desired *desired,
              const genom_context self)
{
  or_pose_estimator_state *d = desired->data(self);
  if (d) {
    d->pos._present = d->att._present = false;
    d->vel._present = d->avel._present = d->acc._present = false;
  }
  return maneuver_wait;
}


/** Codel mv_exec_wait of task exec.
 *
 * Triggered by maneuver_wait.
 * Yields to maneuver_pause_wait, maneuver_main.
 */
genom_event
mv_exec_wait(const maneuver_state *state,
             const maneuver_ids_trajectory_s *trajectory,
             const genom_context self)
{
  (void)known(state, self);
  return trajectory->running ? maneuver_main : maneuver_pause_wait;
}


/** Codel mv_exec_main of task exec.
 *
 * Triggered by maneuver_main.
 * Yields to maneuver_pause_main, maneuver_done.
 */
genom_event
mv_exec_main(const maneuver_state *state,
             maneuver_ids_trajectory_s *trajectory,
             const maneuver_desired *desired,
             const genom_context self)
{
  const or_pose_estimator_state *s = known(state, self);
  or_pose_estimator_state *d = desired->data(self);
  maneuver_path_s *samples = &trajectory->samples;
  if (trajectory->running && d && samples->_length) {
    /* The sample whose time has come: periods may be late. */
    uint32_t last = samples->_length - 1, *i = &trajectory->current;
    if (!s && *i < last) ++*i;
    while (s && *i < last && seconds(samples->_buffer[*i + 1].ts) <= seconds(s->ts)) ++*i;
    *d = samples->_buffer[*i];
    if (s) d->ts = s->ts;
    (void)desired->write(self);
    if (*i < last) return maneuver_pause_main;
  }

  trajectory->running = false;
  samples->_length = trajectory->current = 0;
  return maneuver_done;
}


/** Codel mv_exec_done of task exec.
 *
 * Triggered by maneuver_done.
 * Yields to maneuver_pause_wait.
 */
genom_event
mv_exec_done(const genom_context self)
{
  (void)self;
  return maneuver_pause_wait;  /* `done` is entered without pause, which wakes up `goto` */
}


/** Codel mv_exec_stop of task exec.
 *
 * Triggered by maneuver_stop.
 * Yields to maneuver_ether.
 */
genom_event
mv_exec_stop(const genom_context self)
{
  (void)self;
  return maneuver_ether;
}
