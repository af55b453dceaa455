#include <nanobind/nanobind.h>

#include "bind.hpp"

NB_MODULE(_ros, m) {
  nanobind::set_leak_warnings(false);
  m.doc() = "Palpate on ROS 2: nodes that run outside the interpreter (palpate/ros/cpp).";
  nanobind::module_::import_("palpate._core");  // functions of this module take objects of both modules
  nanobind::module_::import_("palpate._dvrk");
  palpate::ros::bind_rcl(m);
  palpate::ros::bind_sim(m);
  palpate::ros::bind_haptics(m);
  palpate::ros::bind_bench(m);
}
