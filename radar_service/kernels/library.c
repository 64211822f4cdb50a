/* Of the library as a whole. Python never imports it as a module: library.py opens it by ctypes. */

#include "geometry.h"

#ifndef SOURCES
#define SOURCES 0
#endif

/* The digest of the sources that it was built from, as build_backend.py and library.py compute it. */
KERNEL int64_t sources(void) { return SOURCES; }
