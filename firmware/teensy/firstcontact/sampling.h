// Sampling in the timer's interrupt at 4936 Hz.
#pragma once

#include "fc_device.h"

// Start sampling for a device, which the caller keeps.
void start_sampling(fc_device *device);

// Take no samples between these two calls. The numbers of the missing samples are skipped.
void pause_sampling();
void resume_sampling();
