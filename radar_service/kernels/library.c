/* Of the library as a whole. Python never imports it as a module: library.py opens it by ctypes. */

#include "geometry.h"

#ifndef SOURCES
#define SOURCES 0
#endif

/* The digest of the sources that it was built from, as build_backend.py and library.py compute it. */
KERNEL uint64_t sources(void) { return SOURCES; }

/* Whether indices (N), N = count, are all at least `low` and less than `limit`. */
KERNEL int inside(int64_t count, const int64_t *index, int64_t low, int64_t limit) {
    int all = 1;
    for (int64_t i = 0; i < count; i++) all &= (index[i] >= low) & (index[i] < limit);
    return all;
}
