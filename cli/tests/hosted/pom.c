#include "acpom.h"
#include "pom_c_types.h"

genom_event
po_start(int32_t *runs, const genom_context self)
{
  (void)self;
  *runs = 0;
  return pom_pause_move;
}

/* The position is the wanted speed; it is absent until there is one. */
genom_event
po_move(const pom_wanted *wanted, const pom_frame *frame, const pom_odometry *odometry,
         const genom_context self)
{
  m_state *state = frame->data(self);

  state->when.sec = 12;
  state->when.nsec = 34;
  state->spread[35] = 0.25;
  if (wanted->read(self) == genom_ok && wanted->data(self) != NULL) {
    state->at._present = true;
    state->at._value.x = wanted->data(self)->vx;
    state->at._value.y = wanted->data(self)->wz;
    state->speed = *wanted->data(self);
  }
  *odometry->data(self) = *state;
  frame->write(self);
  odometry->write(self);
  return pom_pause_move;
}
