#include "ring_gyro/configuration/configuration_reader.h"

#include <algorithm>
#include <numeric>
#include <set>
#include <utility>

#include "ring_gyro/configuration/parameter_text.h"

namespace cvg {
namespace {

using Faults = std::vector<std::string>;

std::string joinLines(const Faults& faults) {
  std::string lines;
  for (const std::string& fault : faults) {
    if (!lines.empty()) lines += '\n';
    lines += fault;
  }
  return lines;
}

/// The text in the file, on one line.
std::string shownValue(const YAML::Node& node) {
  std::string text;
  if (node.IsNull()) return "(nothing)";
  if (node.IsScalar()) {
    text = node.Scalar();
  } else {
    YAML::Emitter emitter;
    emitter << YAML::Flow << node;
    text = emitter.c_str();
  }
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

std::string fault(const std::string& key, const YAML::Node& value, const std::string& what,
                  const Parameter& parameter) {
  return key + " = " + shownValue(value) + ": " + what + "; allowed: " + allowedText(parameter);
}

/// Insertions, deletions and replacements that turn one text into the other.
std::size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row[b.size()];
}

std::string nearestSection(const std::string& name, const Sections& sections) {
  const auto distance = [&](const Section& section) { return editDistance(name, section.name); };
  return std::min_element(
             sections.begin(), sections.end(),
             [&](const Section& a, const Section& b) { return distance(a) < distance(b); })
      ->name;
}

/// The parameter that was probably meant: the same key in another section, or otherwise the key of
/// this section with the fewest edits.
std::string nearestKey(const Section& section, const std::string& key, const Sections& sections) {
  for (const Section& other : sections) {
    for (const Parameter& parameter : other.table.parameters()) {
      if (parameter.key == key) return other.name + "/" + key;
    }
  }
  std::string nearest;
  std::size_t fewest = 0;
  for (const Parameter& parameter : section.table.parameters()) {
    const std::size_t edits = editDistance(key, parameter.key);
    if (nearest.empty() || edits < fewest) {
      nearest = parameter.key;
      fewest = edits;
    }
  }
  return section.name + "/" + nearest;
}

void readList(const std::string& key, const Parameter& parameter, const YAML::Node& value,
              Faults& faults) {
  std::vector<double> numbers;
  for (const YAML::Node& element : value) {
    double number = 0.0;
    Parameter one = parameter;
    one.target = &number;
    const std::string what =
        element.IsScalar() ? storeText(one, element.Scalar()) : std::string("not a number");
    if (!what.empty()) {
      const std::string index = std::to_string(numbers.size());
      faults.push_back(fault(key + "[" + index + "]", element, what, parameter));
    }
    numbers.push_back(number);
  }
  *std::get<std::vector<double>*>(parameter.target) = std::move(numbers);
}

void readValue(const std::string& key, const Parameter& parameter, const YAML::Node& value,
               Faults& faults) {
  const bool is_list = std::holds_alternative<std::vector<double>*>(parameter.target);
  if (is_list && value.IsSequence()) {
    readList(key, parameter, value, faults);
    return;
  }
  const std::string what =
      value.IsScalar() ? storeText(parameter, value.Scalar()) : std::string("not a single value");
  if (!what.empty()) faults.push_back(fault(key, value, what, parameter));
}

void readSection(const Section& section, const YAML::Node& node, const Sections& sections,
                 Faults& faults) {
  const auto& parameters = section.table.parameters();
  std::set<std::string> seen;
  if (node.IsMap()) {
    for (const auto& entry : node) {
      const std::string name = shownValue(entry.first);
      const std::string key = section.name + "/" + name;
      if (!seen.insert(name).second) {
        faults.push_back(key + " = " + shownValue(entry.second) + ": given twice");
        continue;
      }
      const auto parameter =
          std::find_if(parameters.begin(), parameters.end(),
                       [&](const Parameter& candidate) { return candidate.key == name; });
      if (parameter == parameters.end()) {
        faults.push_back(key + " = " + shownValue(entry.second) +
                         ": unknown parameter; did you mean " +
                         nearestKey(section, name, sections) + "?");
      } else {
        readValue(key, *parameter, entry.second, faults);
      }
    }
  } else if (node.IsDefined() && !node.IsNull()) {
    faults.push_back(section.name + " = " + shownValue(node) + ": not a section of parameters");
    return;
  }
  for (const Parameter& parameter : parameters) {
    if (parameter.required && seen.count(parameter.key) == 0) {
      faults.push_back(section.name + "/" + parameter.key +
                       ": missing; it must be given; allowed: " + allowedText(parameter));
    }
  }
}

void applyOverride(YAML::Node& root, const std::string& text, Faults& faults) {
  const std::size_t equals = text.find('=');
  const std::size_t slash = text.find('/');
  if (equals == std::string::npos || slash == std::string::npos || slash == 0 ||
      slash + 1 >= equals) {
    faults.push_back(text + ": not of the form section/key=value");
    return;
  }
  const std::string section = text.substr(0, slash);
  const std::string key = text.substr(slash + 1, equals - slash - 1);
  try {
    YAML::Node value = YAML::Load(text.substr(equals + 1));
    if (root[section].IsDefined() && !root[section].IsMap()) root[section] = YAML::Node();
    root[section][key] = value;
  } catch (const YAML::Exception& error) {
    faults.push_back(text + ": " + error.msg);
  }
}

YAML::Node loadFile(const std::string& path) {
  try {
    return YAML::LoadFile(path);
  } catch (const YAML::BadFile&) {
    throw ConfigurationError({path + ": the file cannot be read"});
  } catch (const YAML::ParserException& error) {
    throw ConfigurationError({path + ":" + std::to_string(error.mark.line + 1) + ":" +
                              std::to_string(error.mark.column + 1) + ": not YAML: " + error.msg});
  }
}

/// Copies the keys of `file`, a map of sections, to `root`, replacing older values.
void layOver(YAML::Node& root, const YAML::Node& file, const std::string& path, Faults& faults) {
  if (!file.IsMap()) {
    faults.push_back(path + ": not a map of sections");
    return;
  }
  for (const auto& section : file) {
    const std::string name = shownValue(section.first);
    if (!section.second.IsMap() || !root[name].IsDefined() || !root[name].IsMap()) {
      root[name] = section.second;
      continue;
    }
    for (const auto& entry : section.second) root[name][shownValue(entry.first)] = entry.second;
  }
}

}  // namespace

ConfigurationError::ConfigurationError(std::vector<std::string> faults)
    : std::runtime_error(joinLines(faults)), faults_(std::move(faults)) {}

void readSections(const YAML::Node& root, const Sections& sections) {
  Faults faults;
  std::set<std::string> seen;
  if (root.IsMap()) {
    for (const auto& entry : root) {
      const std::string name = shownValue(entry.first);
      if (!seen.insert(name).second) {
        faults.push_back(name + ": section given twice");
        continue;
      }
      const auto section =
          std::find_if(sections.begin(), sections.end(),
                       [&](const Section& candidate) { return candidate.name == name; });
      if (section == sections.end()) {
        faults.push_back(name + " = " + shownValue(entry.second) +
                         ": unknown section; did you mean " + nearestSection(name, sections) + "?");
      } else {
        readSection(*section, entry.second, sections, faults);
      }
    }
  } else if (root.IsDefined() && !root.IsNull()) {
    faults.push_back("configuration = " + shownValue(root) + ": not a map of sections");
  }
  for (const Section& section : sections) {
    if (seen.count(section.name) == 0) readSection(section, YAML::Node(), sections, faults);
  }
  if (!faults.empty()) throw ConfigurationError(std::move(faults));
}

LoopConfiguration readConfiguration(const YAML::Node& root, NodeParameters* node) {
  LoopConfiguration configuration;
  NodeParameters unused;
  Sections sections = configuration.sections();
  sections.push_back({"node", {}});
  (node != nullptr ? *node : unused).declare(sections.back().table);
  readSections(root, sections);
  return configuration;
}

LoopConfiguration readConfigurationFile(const std::string& path,
                                        const std::vector<std::string>& overrides,
                                        NodeParameters* node) {
  return readConfigurationFiles({path}, overrides, node);
}

LoopConfiguration readConfigurationFiles(const std::vector<std::string>& paths,
                                         const std::vector<std::string>& overrides,
                                         NodeParameters* node) {
  YAML::Node root;
  Faults faults;
  for (const std::string& path : paths) {
    YAML::Node file = loadFile(path);
    if (path == paths.front()) {
      root = file;
    } else {
      layOver(root, file, path, faults);
    }
  }
  if (overrides.empty() || root.IsMap() || root.IsNull()) {
    for (const std::string& text : overrides) applyOverride(root, text, faults);
  }
  try {
    LoopConfiguration configuration = readConfiguration(root, node);
    configuration.files = paths;
    configuration.files.push_back(configuration.plant.rotation.file);
    if (faults.empty()) return configuration;
  } catch (const ConfigurationError& error) {
    faults.insert(faults.end(), error.faults().begin(), error.faults().end());
  }
  throw ConfigurationError(std::move(faults));
}

}  // namespace cvg
