// What the code for a HALO includes it for.
#pragma once
#include "RadarInfo.h"
