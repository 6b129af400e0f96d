/* A whisker that is pressed, and a flux that becomes a moment. */
#include "../include/vibrissa.h"
#include <stdio.h>

int main(void) {
    const double rigidity = 2.8886e-4, length = 0.075;
    VibrissaBend pressed, read;
    /* What moment holds the tip 30 mm to the side? */
    if (vibrissa_by_point(rigidity, length, 0.065, 0.030, &pressed) != VIBRISSA_OK) return 1;
    printf("point %.9e %.9e %.9e\n", pressed.moment, pressed.force, pressed.slope);
    /* And where is the contact that this moment means, at the same arc length? */
    if (vibrissa_by_moment(rigidity, pressed.moment, pressed.arc_length, false, &read) != VIBRISSA_OK) return 1;
    printf("moment %.9e %.9e\n", read.x, read.y);
    if (vibrissa_by_moment(rigidity, 1.0, 0.075, false, &read) != VIBRISSA_NONE) return 1;
    if (vibrissa_by_moment(rigidity, 1.0, -0.075, false, &read) != VIBRISSA_RANGE) return 1;
    if (vibrissa_by_force(rigidity, 0.1, 0.075, NULL) != VIBRISSA_NULL) return 1;
    if (vibrissa_by_force(rigidity, 0.1, 0.075, &read) != VIBRISSA_OK) return 1;
    printf("force %.9e %.9e %.9e\n", read.x, read.y, read.moment);

    VibrissaCalibration calibration = {{1e-4, -3e-4, 1.2e-2}, {0.6, 0.0, 0.8}, {0.0, 4e-3}, {0.0, 0.04, 0.0, 1e-3}};
    double flux[3] = {7e-4, -3e-4, 1.28e-2}, far[3] = {1.0, 0.0, 0.0}, moment;
    if (vibrissa_moment(&calibration, flux, &moment) != VIBRISSA_OK) return 1;
    printf("flux %.9e\n", moment);
    return vibrissa_moment(&calibration, far, &moment) == VIBRISSA_BEYOND ? 0 : 1;
}
