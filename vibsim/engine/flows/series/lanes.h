/* Runs side by side: the next Taylor steps of several runs at once, see lanes.c; of doubles alone. */
#ifndef VIBSIM_LANES_H
#define VIBSIM_LANES_H

#include "engine.h"
#include "wide.h"

#ifdef LIMBS
#define suits_lanes(run) 0
#else
enum { RUNS_AT_ONCE = 8 }; /* as in vibsim/engine/trajectory.py */
enum { BODY, FAR, ANGLE, BODY_RATE, FAR_RATE, SPEED, COLUMNS }; /* of small scenes; FAR: the second body, or the ground */

typedef double ByLane[RUNS_AT_ONCE] ALIGNED(64);

/* An event function by lane: constant + sum of factor times column. known: order of its zero at the start of the step; no number where it is
 * no such sum; turns: as of the event; used: whether any lane has a factor there.
 */
typedef struct {
    ByLane constant, factor[COLUMNS], known, turns;
    int used[COLUMNS];
} Watched;

/* The mode and the state of each run, and the step that they come to, by lane. table: its rows, then one of all columns at the end of the
 * step, which is `length` behind its start on the grid of time; spin_rate: rate of the speed there; regular: whether the step has the bits
 * of the run by itself; clear: bits of the event functions that stay positive on it.
 */
typedef struct {
    ByLane k, c, offset, constant, constant_far, mobility_far, moves, mass, inertia, unbalance, drag, stall, tolerance;
    ByLane t0, start[COLUMNS], margin;
    ByLane table[SERIES + 1][COLUMNS], h, length, spin_rate;
    long long regular[RUNS_AT_ONCE], clear[RUNS_AT_ONCE];
    Watched watched[MOST_WATCHED];
    Run *runs[RUNS_AT_ONCE];
    const Mode *modes[RUNS_AT_ONCE]; /* that the numbers are of */
    int watched_count, width; /* width: lanes in a vector, 0 where there are none */
} Lanes;

int lanes_in_a_vector(int widest);
void lanes_open(Lanes *l, Run **runs, int count, int widest);
int suits_lanes(const Run *r);
void lanes_step(Lanes *l, Run **runs, unsigned waiting);
#endif

#endif
