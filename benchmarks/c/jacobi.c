/* The plainest loop over two FMI 2.0 instances: motion out of the one, torques out of the other, both step. */

#include <stddef.h>

typedef int Access(void *, const unsigned *, size_t, double *);
typedef int Step(void *, double, double, int);

typedef struct {
    void *instance;
    Access *set, *get;
    Step *step;
    const unsigned *inputs, *outputs; /* of the port */
    size_t n_inputs, n_outputs;
} Unit;

void jacobi(Unit *vehicle, Unit *device, double *motion, double *torques, double h, long steps)
{
    for (long i = 0; i < steps; i++) {
        vehicle->get(vehicle->instance, vehicle->outputs, vehicle->n_outputs, motion);
        device->set(device->instance, device->inputs, device->n_inputs, motion);
        device->get(device->instance, device->outputs, device->n_outputs, torques);
        vehicle->set(vehicle->instance, vehicle->inputs, vehicle->n_inputs, torques);
        vehicle->step(vehicle->instance, (double)i * h, h, 1);
        device->step(device->instance, (double)i * h, h, 1);
    }
}
