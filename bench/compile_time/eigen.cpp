// What everything else is compared with.
#include <Eigen/Dense>
