#include "ring_gyro/common/shell_word.h"

#include <algorithm>
#include <cstring>

namespace cvg {
namespace {

bool isPlain(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
         (c != '\0' && std::strchr("_-./,:=+@%", c) != nullptr);
}

}  // namespace

std::string shellWord(const std::string& path) {
  std::string name = !path.empty() && path[0] == '-' ? "./" + path : path;
  if (!name.empty() && std::all_of(name.begin(), name.end(), isPlain)) return name;
  std::string word = "'";
  for (const char c : name) {
    if (c == '\'') {
      word += "'\\''";
    } else {
      word += c;
    }
  }
  return word + "'";
}

}  // namespace cvg
