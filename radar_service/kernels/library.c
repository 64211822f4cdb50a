/* Python never imports this library as a module: library.py opens it by ctypes. The function is there for linkers that setuptools
 * tells to export it. */

void *PyInit_compiled(void);

void *PyInit_compiled(void) { return 0; }
