#include "palpate/contact/contact.hpp"

#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "palpate/contact/paper_alg1.hpp"
#include "palpate/contact/proxy.hpp"

namespace palpate::contact {
namespace {

struct Entry {
  std::string_view name;
  std::unique_ptr<Method> (*make)(const Options&);
};

template <class T>
std::unique_ptr<Method> make(const Options& options) {
  return std::make_unique<T>(options);
}

/// A method is one file and one line here.
constexpr std::array kMethods = {
    Entry{"proxy", &make<Proxy>},
    Entry{"paper-alg1", &make<PaperAlg1>},
};

}  // namespace

std::unique_ptr<Method> make_method(std::string_view name, const Options& options) {
  if (!(options.radius > 0.0) || !std::isfinite(options.radius))
    throw std::invalid_argument("contact: radius must be a positive length in metres, got " +
                                std::to_string(options.radius));
  std::string known;
  for (const Entry& entry : kMethods) {
    if (entry.name == name) return entry.make(options);
    known += (known.empty() ? "" : ", ") + std::string(entry.name);
  }
  throw std::invalid_argument("contact: no method '" + std::string(name) + "'; there are: " + known);
}

}  // namespace palpate::contact
