/* Of the library as a whole. Python never imports it as a module: library.py opens it by ctypes. */

#include "geometry.h"

#ifndef SOURCES
#define SOURCES 0
#endif

/* The digest of the sources that it was built from, as setup.py and library.py compute it. */
KERNEL int64_t sources(void) { return SOURCES; }

/* There for linkers that setuptools tells to export it. */
void *PyInit_compiled(void);

void *PyInit_compiled(void) { return 0; }
