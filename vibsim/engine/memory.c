/* What a run has freed, the next one uses. */

#include "engine.h"

#if defined(__GLIBC__)
#include <malloc.h>
#include <stdlib.h>
#include <string.h>

enum { KEPT = 64 << 20, BLOCK = 32 << 20 }; /* bytes free at the top of a heap; smaller blocks come from heaps */

/* Let the C library of Linux keep up to 64 MiB of what was freed. By itself it hands some 8 MiB of arrays back to
   the system behind every run, and the next one faults their pages in anew: 2,000 faults, a sixth of the time of
   `simulate("II-B")`. Who has told it otherwise in the environment is obeyed. */
void keep_freed_memory(void)
{
    const char *tunables = getenv("GLIBC_TUNABLES");
    if (getenv("MALLOC_TRIM_THRESHOLD_") || getenv("MALLOC_MMAP_THRESHOLD_") || (tunables && strstr(tunables, "malloc")))
        return;
    mallopt(M_TRIM_THRESHOLD, KEPT);
    mallopt(M_MMAP_THRESHOLD, BLOCK);
}
#else
void keep_freed_memory(void) {}
#endif
