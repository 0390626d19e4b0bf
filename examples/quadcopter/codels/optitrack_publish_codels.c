#include "acoptitrack.h"

#include "optitrack_c_types.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "stamps.h"

/** The stream of a capture server: here, port `cameras`. */
struct optitrack_session_s {
  bool joined;
  bool seen;                      /* a frame has come since it was joined */
  or_pose_estimator_state frame;  /* the last one */
};


/** Codel ot_publish_start of task publish.
 *
 * Triggered by optitrack_start.
 * Yields to optitrack_poll.
 */
genom_event
ot_publish_start(optitrack_session_s **session, char body[64],
                 or_pose_estimator_state *noise,
                 const optitrack_mocap_pose *mocap_pose,
                 const genom_context self)
{
  (void)mocap_pose;
  (void)self;
  *session = calloc(1, sizeof **session);
  snprintf(body, 64, "quadcopter");
  memset(noise, 0, sizeof *noise);
  return optitrack_poll;
}


/** Codel ot_publish_poll of task publish.
 *
 * Triggered by optitrack_poll.
 * Yields to optitrack_pause_poll, optitrack_frame.
 */
genom_event
ot_publish_poll(const optitrack_cameras *cameras,
                optitrack_session_s **session,
                const genom_context self)
{
  optitrack_session_s *s = *session;
  if (!s || !s->joined) return optitrack_pause_poll;
  if (cameras->read(self) != genom_ok) return optitrack_pause_poll;

  const or_pose_estimator_state *seen = cameras->data(self);
  if (!seen || !seen->pos._present || !seen->att._present) return optitrack_pause_poll;
  if (s->seen && seconds(seen->ts) <= seconds(s->frame.ts)) return optitrack_pause_poll;
  s->frame = *seen;
  s->seen = true;
  return optitrack_frame;
}


/** Codel ot_publish_frame of task publish.
 *
 * Triggered by optitrack_frame.
 * Yields to optitrack_pause_poll.
 */
genom_event
ot_publish_frame(const optitrack_session_s *session,
                 const char body[64],
                 const or_pose_estimator_state *noise,
                 const optitrack_mocap_pose *mocap_pose,
                 const genom_context self)
{
  (void)body;
  or_pose_estimator_state *pose = mocap_pose->data(self);
  if (!pose) return optitrack_pause_poll;

  /* Cameras see the pose. Velocities are left to the pose estimator. */
  *pose = *noise;
  pose->ts = session->frame.ts;
  pose->intrinsic = false;
  pose->pos = session->frame.pos;
  pose->att = session->frame.att;
  pose->vel._present = pose->avel._present = pose->acc._present = false;
  (void)mocap_pose->write(self);
  return optitrack_pause_poll;
}


/** Codel ot_publish_stop of task publish.
 *
 * Triggered by optitrack_stop.
 * Yields to optitrack_ether.
 */
genom_event
ot_publish_stop(optitrack_session_s **session,
                const genom_context self)
{
  (void)self;
  free(*session);
  *session = NULL;
  return optitrack_ether;
}


/** Codel ot_connect_start of activity connect.
 *
 * Triggered by optitrack_start.
 * Yields to optitrack_pause_wait.
 * Throws optitrack_e_network, optitrack_e_unknown_body.
 */
genom_event
ot_connect_start(const char host[128], uint16_t control, uint16_t data,
                 optitrack_session_s **session,
                 const genom_context self)
{
  (void)control;
  (void)data;
  if (!*session || !host[0]) {
    optitrack_e_network_detail d = {.code = 0};
    snprintf(d.what, sizeof d.what, "no capture server at `%.90s`", host);
    return optitrack_e_network(&d, self);
  }
  (*session)->joined = true;
  (*session)->seen = false;
  return optitrack_pause_wait;
}


/** Codel ot_connect_wait of activity connect.
 *
 * Triggered by optitrack_wait.
 * Yields to optitrack_pause_wait, optitrack_ether.
 * Throws optitrack_e_network, optitrack_e_unknown_body.
 */
genom_event
ot_connect_wait(const char body[64], optitrack_session_s **session,
                const genom_context self)
{
  if (!body[0]) return optitrack_e_unknown_body(self);
  return (*session)->seen ? optitrack_ether : optitrack_pause_wait;
}


/** Codel ot_connect_stop of activity connect.
 *
 * Triggered by optitrack_stop.
 * Yields to optitrack_ether.
 * Throws optitrack_e_network, optitrack_e_unknown_body.
 */
genom_event
ot_connect_stop(optitrack_session_s **session,
                const genom_context self)
{
  (void)self;
  (*session)->joined = false;
  return optitrack_ether;
}


/** Codel ot_disconnect_start of activity disconnect.
 *
 * Triggered by optitrack_start.
 * Yields to optitrack_ether.
 * Throws optitrack_e_network.
 */
genom_event
ot_disconnect_start(optitrack_session_s **session,
                    const genom_context self)
{
  (void)self;
  if (*session) (*session)->joined = false;
  return optitrack_ether;
}
