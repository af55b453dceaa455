#include "palpate/torque/law.hpp"

#include <cmath>
#include <stdexcept>

#include "palpate/types/require.hpp"

namespace palpate::torque {
namespace {

struct Entry {
  const char* name;
  std::unique_ptr<ControlLaw> (*make)(const ControlLawOptions&, double);
};

constexpr Entry kLaws[] = {
    {"stiffness", &make_stiffness}, {"impedance", &make_impedance}, {"admittance", &make_admittance}};

}  // namespace

std::unique_ptr<ControlLaw> make_control_law(const std::string& name, const ControlLawOptions& options, double dt) {
  require("torque", options.virtual_mass >= 0.05 && std::isfinite(options.virtual_mass), "virtual_mass",
          options.virtual_mass, "must be 0.05 kg or more: a lighter handle would answer to noise");
  require("torque", options.virtual_damping >= 0.0 && std::isfinite(options.virtual_damping), "virtual_damping",
          options.virtual_damping, "must be 0 N s/m or more");
  require("torque", name != "admittance" || (options.servo_bandwidth > 0.0 && options.servo_bandwidth * dt <= 0.05),
          "servo_bandwidth", options.servo_bandwidth,
          "must be above 0 and at most a twentieth of the cycle's rate [Hz]");
  std::string names;
  for (const Entry& law : kLaws) {
    if (name == law.name) return law.make(options, dt);
    names += (names.empty() ? "" : ", ") + std::string(law.name);
  }
  throw std::invalid_argument("torque.law = '" + name + "': the laws are " + names);
}

}  // namespace palpate::torque
