#include "acsimulator.h"

#include "simulator_c_types.h"

#include "attitude.h"

static const double period = 1e-3;  /* s, of task physics */

/** Returns a number between -1 and 1, by a linear congruential generator. */
static double
noise(uint32_t *seed)
{
  *seed = *seed * 1664525u + 1013904223u;
  return *seed / 2147483648. - 1.;
}

static or_time_ts
stamp(uint32_t ticks)
{
  return (or_time_ts){.sec = (int32_t)(ticks / 1000), .nsec = ticks % 1000 * 1000000};
}

/** Writes what sensors and cameras see. */
static genom_event
publish(const simulator_ids_rigid_s *rigid, uint32_t ticks, uint32_t *seed,
        const simulator_turning *turning, const simulator_inertia *inertia,
        const simulator_body *body, const genom_context self)
{
  or_time_ts now = stamp(ticks);

  quad_rotors_velocities *velocities = turning->data(self);
  quad_rotors_inertial *unit = inertia->data(self);
  or_pose_estimator_state *state = body->data(self);
  if (!velocities || !unit || !state) return genom_ok;

  velocities->ts = now;
  velocities->w._length = simulator_rotors;
  for (int i = 0; i < simulator_rotors; i++) velocities->w._buffer[i] = rigid->rotor[i];

  /* An inertial unit measures the force on it: acceleration, less gravity. */
  struct quat q = {rigid->q.qw, rigid->q.qx, rigid->q.qy, rigid->q.qz};
  struct vec force = {rigid->a.ax, rigid->a.ay, rigid->a.az + GRAVITY};
  force = quat_rotate(quat_inverse(q), force);
  unit->ts = now;
  unit->gyro.wx = rigid->w.wx + .01 * noise(seed);
  unit->gyro.wy = rigid->w.wy + .01 * noise(seed);
  unit->gyro.wz = rigid->w.wz + .01 * noise(seed);
  unit->accel.ax = force.x + .1 * noise(seed);
  unit->accel.ay = force.y + .1 * noise(seed);
  unit->accel.az = force.z + .1 * noise(seed);

  state->ts = now;
  state->intrinsic = false;
  state->pos._present = state->att._present = true;
  state->vel._present = state->avel._present = state->acc._present = true;
  state->pos._value = rigid->p;
  state->att._value = rigid->q;
  state->vel._value = rigid->v;
  struct vec w = quat_rotate(q, (struct vec){rigid->w.wx, rigid->w.wy, rigid->w.wz});
  state->avel._value = (or_t3d_avel){w.x, w.y, w.z};
  state->acc._value = rigid->a;

  genom_event e = turning->write(self);
  if (!e) e = inertia->write(self);
  if (!e) e = body->write(self);
  return e;
}


/* --- Task physics ----------------------------------------------------- */


/** Codel sim_start of task physics.
 *
 * Triggered by simulator_start.
 * Yields to simulator_step.
 */
genom_event
sim_start(simulator_ids *ids, const simulator_turning *turning,
          const simulator_inertia *inertia, const simulator_body *body,
          const genom_context self)
{
  ids->airframe = (simulator_ids_airframe_s){
    .mass = 1., .arm = .23, .thrust = 6.5e-4, .drag = 1e-5, .friction = .1, .lag = .015,
    .jxy = .015, .jz = .025};
  ids->rigid = (simulator_ids_rigid_s){.q = {.qw = 1.}};
  ids->wind = (or_t3d_vel){0., 0., 0.};
  ids->ticks = 0;
  ids->seed = 1;
  (void)publish(&ids->rigid, ids->ticks, &ids->seed, turning, inertia, body, self);
  return simulator_step;
}


/** Codel sim_step of task physics.
 *
 * Triggered by simulator_step.
 * Yields to simulator_pause_step.
 */
genom_event
sim_step(const simulator_command *command,
         const simulator_ids_airframe_s *airframe,
         const or_t3d_vel *wind, simulator_ids_rigid_s *rigid,
         uint32_t *ticks, uint32_t *seed,
         const simulator_turning *turning,
         const simulator_inertia *inertia, const simulator_body *body,
         const genom_context self)
{
  /* Propellers follow their command: first order. */
  const quad_rotors_velocities *wanted = NULL;
  if (command->read(self) == genom_ok) wanted = command->data(self);
  double lift[simulator_rotors], total = 0.;
  for (int i = 0; i < simulator_rotors; i++) {
    double to = wanted && (uint32_t)i < wanted->w._length ? wanted->w._buffer[i] : 0.;
    rigid->rotor[i] += (to - rigid->rotor[i]) * period / airframe->lag;
    lift[i] = rigid->rotor[i] * rigid->rotor[i];
    total += lift[i];
  }

  /* Propellers: front, left, back, right; front and back turn to the left. */
  double k = airframe->thrust;
  struct vec torque = {
    airframe->arm * k * (lift[1] - lift[3]),
    airframe->arm * k * (lift[2] - lift[0]),
    airframe->drag * (lift[1] + lift[3] - lift[0] - lift[2])};

  struct quat q = {rigid->q.qw, rigid->q.qx, rigid->q.qy, rigid->q.qz};
  struct vec p = {rigid->p.x, rigid->p.y, rigid->p.z};
  struct vec v = {rigid->v.vx, rigid->v.vy, rigid->v.vz};
  struct vec w = {rigid->w.wx, rigid->w.wy, rigid->w.wz};

  struct vec air = vec_sum((struct vec){wind->vx, wind->vy, wind->vz}, vec_times(v, -1.));
  struct vec force = vec_sum(quat_rotate(q, (struct vec){0., 0., k * total}),
                             vec_times(air, airframe->friction));
  struct vec a = vec_sum(vec_times(force, 1. / airframe->mass), (struct vec){0., 0., -GRAVITY});

  struct vec spin = {airframe->jxy * w.x, airframe->jxy * w.y, airframe->jz * w.z};
  torque = vec_sum(torque, vec_times(vec_cross(w, spin), -1.));

  if (p.z <= 0. && a.z <= 0.) {
    /* It stands on the ground. */
    double yaw = quat_yaw(q);
    p.z = 0.;
    a = v = w = (struct vec){0., 0., 0.};
    q = quat_turn((struct vec){0., 0., yaw});
  } else {
    v = vec_sum(v, vec_times(a, period));
    p = vec_sum(p, vec_times(v, period));
    w.x += torque.x / airframe->jxy * period;
    w.y += torque.y / airframe->jxy * period;
    w.z += torque.z / airframe->jz * period;
    q = quat_unit(quat_times(q, quat_turn(vec_times(w, period))));
  }

  rigid->p = (or_t3d_pos){p.x, p.y, p.z};
  rigid->q = (or_t3d_att){q.w, q.x, q.y, q.z};
  rigid->v = (or_t3d_vel){v.x, v.y, v.z};
  rigid->w = (or_t3d_avel){w.x, w.y, w.z};
  rigid->a = (or_t3d_acc){a.x, a.y, a.z};
  (*ticks)++;
  (void)publish(rigid, *ticks, seed, turning, inertia, body, self);
  return simulator_pause_step;
}
