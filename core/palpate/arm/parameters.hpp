// Reads the parameters of a device and reports the one that is missing, invalid or unknown.
#pragma once

#include <set>
#include <string>

#include "palpate/arm/mechanism.hpp"

namespace palpate::arm {

class Reader {
 public:
  Reader(std::string kind, const Parameters& parameters) : kind_(std::move(kind)), parameters_(parameters) {}

  /// One number above zero. Throws std::runtime_error naming the parameter.
  double positive(const std::string& name, const std::string& meaning);
  /// One finite number, or `otherwise` if it is not given.
  double number(const std::string& name, const std::string& meaning, double otherwise);
  /// Throws std::runtime_error if a given name has not been read.
  void done() const;
  /// Throws std::runtime_error with the fault `what` and the remedy `mend` unless `good`.
  void require(bool good, const std::string& what, const std::string& remedy) const;

 private:
  [[nodiscard]] const double* find(const std::string& name, const std::string& meaning);

  std::string kind_;
  const Parameters& parameters_;
  std::set<std::string> asked_;
};

}  // namespace palpate::arm
