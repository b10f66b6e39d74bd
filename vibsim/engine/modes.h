/* Scenes and modes from packed numbers. */
#ifndef VIBSIM_MODES_H
#define VIBSIM_MODES_H

#include "engine.h"
#include "reading.h"

int scene_read(Run *r, Reader *in);       /* whether the numbers made a scene */
Mode *mode_read(Run *r, Reader *in);      /* NULL without memory; look at the reader for what else was wrong */
int mode_add(Run *r, Mode *m);
void mode_free(Mode *m);
void run_free(Run *r);

#endif
