#include "ring_gyro/nodes/output.h"

#include <algorithm>

namespace ring_gyro::nodes {

void Output::add(Names& names, const std::string& name) { names.push_back(name); }

void Output::remove(Names& names, const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) names.erase(found);
}

bool Output::hasListener(const std::string& node) const {
  return std::find(names_->begin(), names_->end(), node) != names_->end();
}

std::string Output::listeners() const {
  std::string text;
  for (const std::string& name : *names_) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "nobody" : text;
}

}  // namespace ring_gyro::nodes
