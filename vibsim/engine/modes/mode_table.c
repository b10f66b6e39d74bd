/* The modes that a run has met, and the end of what they and the run hold. */
#include <stdlib.h>
#include <string.h>

#include "modes.h"

void mode_free(Mode *m)
{
    if (m)
        free(m->terms);
    free_owner(m);
}

/* Add a mode; its number, or -1 without memory. Sets how many keys of zeros there are. */
int mode_add(Run *r, Mode *m)
{
    Search *s = &r->closed_form.search;
    int keys = r->key_count, events = r->event_room, i;
    for (i = 0; i < m->event_count; i++)
        keys = m->events[i].key >= keys ? m->events[i].key + 1 : keys;
    if (!grow((void **)&r->modes, (size_t)r->mode_count, (size_t)r->mode_count + 1, sizeof(Mode *)) ||
        !grow((void **)&r->known, (size_t)r->key_count, (size_t)keys + 1, sizeof(int)) ||
        !grow((void **)&r->behind, (size_t)r->key_count, (size_t)keys + 1, sizeof(int)))
        return -1;
    r->key_count = keys;
    if (m->event_count > events) {
        if (!grow((void **)&s->watched, (size_t)events, (size_t)m->event_count, sizeof *s->watched) ||
            !grow((void **)&s->rounding_bounds, (size_t)events, (size_t)m->event_count, sizeof(RoundingBound)) ||
            !grow((void **)&s->events, (size_t)events, (size_t)m->event_count, sizeof(int)))
            return -1;
        r->event_room = m->event_count;
    }
    r->modes[r->mode_count] = m;
    return r->mode_count++;
}

int modes_forget(Run *r)
{
    int number = r->mode_number, i;
    Mode *now = r->modes[number];
    for (i = 0; i < r->mode_count; i++)
        if (i != number)
            mode_free(r->modes[i]);
    for (i = 0; i < now->event_count; i++)
        now->events[i].rule.kind = DECIDE_IN_PYTHON;
    r->modes[0] = now;
    r->mode_count = 1;
    r->mode_number = r->certificate.mode = 0;
    return number;
}

int mode_renew(Run *r, int number, Mode *m)
{
    Mode *before = r->modes[number];
    int i;
    if (m->event_count != before->event_count || before->integrals.integrals)
        return 0;
    for (i = 0; i < m->event_count; i++) {
        Event *e = &m->events[i], *one = &before->events[i];
        int same = e->kind == one->kind && e->key == one->key && e->terms == one->terms, k;
        for (k = 0; same && k < e->terms; k++)
            same = m->terms[e->first + k].kind == before->terms[one->first + k].kind;
        if (!same)
            return 0;
        e->rule = one->rule;
    }
    mode_free(before);
    r->modes[number] = m;
    return 1;
}

void run_free(Run *r)
{
    Search *s = &r->closed_form.search;
    int i;
    for (i = 0; i < r->mode_count; i++)
        mode_free(r->modes[i]);
    ledger_free(&r->ledger);
    tangent_free(r->tangent);
    free(r->modes);
    free(r->known);
    free(r->behind);
    free(s->watched);
    free(s->rounding_bounds);
    free(s->events);
    free_tapes(&r->taylor.tapes);
    free_tapes(&r->taylor.base_tapes);
#ifdef FIXED_SERIES
    fixed_table_free(r->taylor.fixed);
#endif
    free_owner(r->masses);
}
