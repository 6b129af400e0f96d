/* A whisker that is pressed, a flux that becomes a moment, and one that becomes a contact in space. */
#include "../include/vibrissa.h"
#include <math.h>
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
    if (vibrissa_moment(&calibration, far, &moment) != VIBRISSA_BEYOND) return 1;

    /* Both transverse axes: size and direction of the moment, and the contact of the tip at its angle about the whisker. */
    VibrissaPlane plane = {{1e-4, -3e-4, 6e-3}, {{-1.5, 9.0, 0.1}, {-9.2, -1.4, 0.0}}, {{1e-4, 0.02}, {-2e-4, 0.02}},
                           {{0, 0.02, 0, 0, 1e-4, 0, 3e-4, 0, 0, 0}, {0, 0, 0.02, 2e-4, 0, 0, 0, 0, 0, 4e-4}}};
    double askew[3] = {3e-4, 2e-4, 6.1e-3}, moments[2];
    if (vibrissa_moments(&plane, askew, NULL) != VIBRISSA_NULL) return 1;
    if (vibrissa_moments(&plane, far, moments) != VIBRISSA_BEYOND) return 1;
    if (vibrissa_moments(&plane, askew, moments) != VIBRISSA_OK) return 1;
    printf("both %.9e %.9e\n", moments[0], moments[1]);
    if (vibrissa_by_moment(rigidity, hypot(moments[0], moments[1]), length, false, &read) != VIBRISSA_OK) return 1;
    printf("space %.9e %.9e %.9e\n", read.x, read.y, atan2(moments[1], moments[0]));
    return 0;
}
