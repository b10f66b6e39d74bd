/* Scenes and modes from packed numbers: scene.c, modes.c, mode_table.c. */
#ifndef VIBSIM_MODES_H
#define VIBSIM_MODES_H

#include "engine.h"
#include "reading.h"

int scene_read(Run *r, Reader *in);       /* whether the numbers made a scene */
int scene_retune(Run *r, Reader *in);     /* the numbers of another scene of that shape; whether they were as many */
void place_rotors(Rotors *o);             /* what lies behind `sine` and `mass` */
int named_by(const Run *r, const Mode *m, int kind); /* how many of what a kind of term names by its P a mode has */
Mode *mode_read(Run *r, Reader *in);      /* NULL without memory; look at the reader for what else was wrong */
int mode_add(Run *r, Mode *m);
int modes_forget(Run *r); /* all but that of now, which is number 0 then and without rules; its number before */
int mode_renew(Run *r, int number, Mode *m); /* a mode of the same form in the place of another; whether it has it */

/* modal_rows.c */
Modal *modal_read(const Run *r, Reader *in, int pairs, int events);
void modal_tune(const Run *r, Modal *m);  /* to the frequencies of the drives */
void modal_prepare(Mode *m);              /* for the event functions */
void function_prepare(Mode *m, Event *e); /* in the closed form of its mode, where it has one */

int formulas_read(Run *r, Reader *in, Mode *m, int ops, int base_ops); /* formula_rows.c; 0 without memory, or look at the reader */

int slopes_read(Run *r, Mode *m, Reader *in); /* their derivatives; 0 without memory, or look at the reader */
int alloc_tapes(TapeRoom *tapes, int ops);
void free_tapes(TapeRoom *tapes);

void mode_free(Mode *m);
void run_free(Run *r);

/* reading_tangent.c */
int tangent_alloc_formulas(const Run *r, struct Tangent *b);

/* ledger_integrals.c; 0 without memory, or where the numbers are not what they should be (look at the reader) */
int ledger_read(Run *r, Reader *in);
int integrals_read(Run *r, Mode *m, Reader *in);
int extremes_read(Run *r, Reader *in); /* extremes.c */
int impacts_read(Run *r, Reader *in);    /* reading_impacts.c */
void ledger_free(Ledger *l);

#endif
