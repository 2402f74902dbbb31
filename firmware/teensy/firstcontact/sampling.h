// Samples, taken in the timer's interrupt at 4936 Hz.
#pragma once

#include "fc_device.h"

// The device stays.
void start_sampling(fc_device *device);

// In between no sample is taken; the numbers of those that are missing are left out.
void pause_sampling();
void resume_sampling();
