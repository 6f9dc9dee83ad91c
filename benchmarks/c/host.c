/* A host of one FMI 2.0 instance: steps it, and reads a few values after every step. */

#include <stddef.h>

typedef int Get(void *, const unsigned *, size_t, double *);
typedef int Step(void *, double, double, int);

void host(void *instance, Step *step, Get *get, const unsigned *references, size_t n, double *values, double h, long begin, long end)
{
    for (long i = begin; i < end; i++) {
        step(instance, (double)i * h, h, 1);
        get(instance, references, n, values);
    }
}
