// Devices that are not described by a URDF. A new one is a file of its own and a line in this table.
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "palpate/arm/delta.hpp"
#include "palpate/arm/parameters.hpp"

namespace palpate::arm {
namespace {

struct Kind {
  const char* name;
  std::unique_ptr<Mechanism> (*make)(const Parameters&);
};

constexpr Kind kKinds[] = {{"delta", &make_delta}};

}  // namespace

const LaneDynamics& Mechanism::lane_dynamics(const JointVector& q, const JointVector& v, const TipBody& body,
                                             LaneDynamics& out) noexcept {
  Dynamics d;
  dynamics(q, v, d);
  for (Eigen::Index k = 0; k < d.bias.size(); ++k) {
    for (Eigen::Index i = 0; i < d.bias.size(); ++i) {
      const auto J_k = d.J.col(k), J_i = d.J.col(i);
      out.M[k][i] =
          d.M(k, i) + body.mass * J_k.head<3>().dot(J_i.head<3>()) + body.inertia * J_k.tail<3>().dot(J_i.tail<3>());
    }
    for (int r = 0; r < 6; ++r) out.J[r][k] = d.J(r, k);
    out.bias[k] = d.bias[k];
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) out.tip[j][i] = d.X_0T.R(i, j);
    out.tip[3][i] = d.X_0T.p[i];
    out.Jdot_v[i] = d.Jdot_v[i];
    out.Jdot_v[4 + i] = d.Jdot_v[3 + i];
  }
  return out;
}

void Mechanism::inverse_dynamics(const JointVector& q, const JointVector& v, const JointVector& a, Dynamics& work,
                                 JointVector& tau) noexcept {
  dynamics(q, v, work);
  tau.noalias() = work.M * a + work.bias;
}

std::unique_ptr<Mechanism> make_mechanism(const std::string& kind, const Parameters& parameters) {
  std::string names;
  for (const Kind& k : kKinds) {
    if (kind == k.name) return k.make(parameters);
    names += (names.empty() ? "" : ", ") + std::string(k.name);
  }
  throw std::runtime_error("there is no kind of device '" + kind + "'; there are: " + names);
}

const double* Reader::find(const std::string& name, const std::string& meaning) {
  asked_.insert(name);
  const auto it = parameters_.find(name);
  if (it == parameters_.end()) return nullptr;
  require(it->second.size() == 1 && std::isfinite(it->second[0]), name + " must be one finite number", meaning);
  return it->second.data();
}

double Reader::positive(const std::string& name, const std::string& meaning) {
  const double* value = find(name, meaning);
  require(value != nullptr, name + " is missing", "give the " + meaning);
  require(*value > 0.0, name + " = " + std::to_string(*value) + " must be above zero", meaning);
  return *value;
}

double Reader::number(const std::string& name, const std::string& meaning, double otherwise) {
  const double* value = find(name, meaning);
  return value != nullptr ? *value : otherwise;
}

void Reader::done() const {
  std::string names;
  for (const std::string& name : asked_) names += (names.empty() ? "" : ", ") + name;
  for (const auto& [name, values] : parameters_) {
    require(asked_.count(name) > 0, "there is no parameter '" + name + "'", "there are: " + names);
  }
}

void Reader::require(bool good, const std::string& what, const std::string& remedy) const {
  if (!good) throw std::runtime_error("device " + kind_ + ": " + what + " (" + remedy + ")");
}

}  // namespace palpate::arm
