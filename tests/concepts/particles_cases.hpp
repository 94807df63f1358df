// What particles.test.cpp and particles.full.cpp share.
#pragma once

#include <phistep/io.hpp>
#include <phistep/particles.hpp>

#include <sstream>

#include "support/catch.hpp"
