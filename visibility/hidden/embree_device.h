// embree_device.h - Embree with one thread, which ends the program where it has no memory, since Embree would trace an incomplete scene.
#ifndef HIDDEN_EMBREE_DEVICE_H
#define HIDDEN_EMBREE_DEVICE_H

#include <embree3/rtcore.h>

#include "engine/core/memory.h"

static inline void embree_fail(void *context, enum RTCError code, const char *text) {
    (void)context, (void)text;
    if (code == RTC_ERROR_OUT_OF_MEMORY) memory_end_library("Embree");
}

// Never NULL.
static inline RTCDevice embree_device_new(void) {
    RTCDevice device = rtcNewDevice("threads=1");
    if (!device) memory_end_library("Embree");
    rtcSetDeviceErrorFunction(device, embree_fail, NULL);
    return device;
}

#endif
