// Reads a device's numbers, and says which one is missing, wrong or unknown.
#pragma once

#include <set>
#include <string>

#include "palpate/arm/mechanism.hpp"

namespace palpate::arm {

class Reader {
 public:
  Reader(std::string kind, const Parameters& parameters) : kind_(std::move(kind)), parameters_(parameters) {}

  /// One number above zero. Throws std::runtime_error.
  double positive(const std::string& name, const std::string& meaning);
  /// One finite number, or `otherwise` when it is not given.
  double number(const std::string& name, const std::string& meaning, double otherwise);
  /// Throws when a name was given that nobody asked for.
  void done() const;
  /// Throws std::runtime_error unless `good`.
  void require(bool good, const std::string& what, const std::string& remedy) const;

 private:
  [[nodiscard]] const double* find(const std::string& name, const std::string& meaning);

  std::string kind_;
  const Parameters& parameters_;
  std::set<std::string> asked_;
};

}  // namespace palpate::arm
