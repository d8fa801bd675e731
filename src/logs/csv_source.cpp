#include "ring_gyro/logs/csv_source.h"

#include <algorithm>
#include <array>
#include <boost/algorithm/string/trim.hpp>

#include "ring_gyro/common/number_text.h"
#include "ring_gyro/logs/log_error.h"
#include "ring_gyro/logs/unit.h"

namespace cvg {
namespace {

constexpr std::size_t kLinesToLookAt = 200;
constexpr std::size_t kMostToLookAt = std::size_t{4} << 20;  // bytes
constexpr std::size_t kMostColumns = 100000;
constexpr char kMendOfCommas[] =
    "write the file with ';' between the fields, with decimal points or with the numbers in quotes";
constexpr std::array<char, 5> kDelimiters = {'\t', ';', ',', '|', ' '};

bool isBlank(char c) { return c == ' ' || c == '\t'; }

bool isEmpty(std::string_view line) { return std::all_of(line.begin(), line.end(), isBlank); }

std::string_view unquoted(std::string_view field) {
  while (!field.empty() && isBlank(field.front())) field.remove_prefix(1);
  while (!field.empty() && isBlank(field.back())) field.remove_suffix(1);
  if (field.size() >= 2 && field.front() == '"' && field.back() == '"') {
    field = field.substr(1, field.size() - 2);
  }
  return field;
}

bool isComment(std::string_view line) {
  const std::size_t first = line.find_first_not_of(" \t");
  return first != std::string_view::npos && (line[first] == '#' || line[first] == '%');
}

/// First lines of a file, parsed with one dialect.
struct Layout {
  std::size_t first_row = 0;  // index of the first line with numbers
  std::size_t fields = 0;
  std::size_t numeric_rows = 0;
};

std::size_t numericFields(const std::vector<std::string_view>& fields, char decimal) {
  return static_cast<std::size_t>(std::count_if(
      fields.begin(), fields.end(),
      [decimal](std::string_view field) { return parseNumber(field, decimal).has_value(); }));
}

/// Whether each number may have been split into two fields at its decimal comma: the delimiter is a
/// comma, and no number has a point or quotes.
bool mayBeSplitAtDecimals(const std::vector<std::string>& lines, std::size_t first_row,
                          char delimiter) {
  return delimiter == ',' && std::all_of(lines.begin() + static_cast<std::ptrdiff_t>(first_row),
                                         lines.end(), [](const std::string& line) {
                                           return isComment(line) ||
                                                  line.find_first_of(".\"") == std::string::npos;
                                         });
}

/// Whether this is a row of the table, not a header: at least half of the fields are numbers.
bool isRow(const std::vector<std::string_view>& fields, char decimal) {
  return 2 * numericFields(fields, decimal) >= fields.size();
}

/// Number of lines that form a table with this dialect, and where the table begins.
Layout layoutOf(const std::vector<std::string>& lines, char delimiter, char decimal) {
  std::vector<std::string_view> fields;
  Layout layout;
  for (std::size_t k = lines.size(); k-- > 0;) {
    if (isEmpty(lines[k]) || isComment(lines[k])) continue;
    splitFields(lines[k], delimiter, fields);
    if (!isRow(fields, decimal)) continue;
    if (layout.fields == 0 || fields.size() == layout.fields) {
      // The last row may be cut at the end of the examined text.
      layout.fields = fields.size();
      ++layout.numeric_rows;
      layout.first_row = k;
    } else if (layout.numeric_rows < 2) {
      layout = {k, fields.size(), 1};
    }
  }
  return layout;
}

std::vector<std::string> textsOf(std::string_view line, char delimiter) {
  std::vector<std::string_view> fields;
  splitFields(line, delimiter, fields);
  return {fields.begin(), fields.end()};
}

std::string nameOf(char delimiter) {
  if (delimiter == '\t') return "tab";
  if (delimiter == ' ') return "blank";
  return std::string("'") + delimiter + "'";
}

}  // namespace

void splitFields(std::string_view line, char delimiter, std::vector<std::string_view>& fields) {
  fields.clear();
  if (delimiter == ' ') {
    std::size_t at = 0;
    while ((at = line.find_first_not_of(" \t", at)) != std::string_view::npos) {
      const std::size_t quote = line[at] == '"' ? line.find('"', at + 1) : std::string_view::npos;
      const std::size_t from = quote == std::string_view::npos ? at : quote;
      const std::size_t stop = std::min(line.find_first_of(" \t", from), line.size());
      fields.push_back(unquoted(line.substr(at, stop - at)));
      at = stop;
    }
    return;
  }
  std::size_t begin = 0;
  bool quoted = false;
  for (std::size_t k = 0; k <= line.size(); ++k) {
    if (k < line.size() && line[k] == '"') quoted = !quoted;
    if (k < line.size() && (quoted || line[k] != delimiter)) continue;
    fields.push_back(unquoted(line.substr(begin, k - begin)));
    begin = k + 1;
  }
}

CsvSource::CsvSource(const std::string& path, const CsvDialect& dialect)
    : dialect_(dialect), lines_(path) {
  std::vector<std::string> head;
  {
    LineReader reader(path);
    std::string_view line;
    std::size_t size = 0;
    while (head.size() < dialect.skipped_lines + kLinesToLookAt && size < kMostToLookAt &&
           reader.next(line)) {
      size += line.size();
      head.emplace_back(reader.number() <= dialect.skipped_lines ? "" : std::string(line));
    }
  }
  // Choose the dialect with the most rows of numbers and, among these, the most fields per row.
  Layout best;
  std::size_t best_score = 0;
  for (const char delimiter : kDelimiters) {
    if (dialect.delimiter != 0 && delimiter != dialect.delimiter) continue;
    for (const char decimal : {'.', ','}) {
      if (dialect.decimal != 0 && decimal != dialect.decimal) continue;
      const Layout layout = layoutOf(head, delimiter, decimal);
      const bool alone = dialect.delimiter == 0 && layout.fields < 2;
      const std::size_t score = alone ? 0 : 1000 * layout.numeric_rows + layout.fields;
      if (score <= best_score) continue;
      best = layout;
      best_score = score;
      dialect_.delimiter = delimiter;
      dialect_.decimal = decimal;
    }
  }
  if (best_score == 0) {
    const bool nothing = std::all_of(head.begin(), head.end(), [](const std::string& line) {
      return isEmpty(line) || isComment(line);
    });
    throw LogError(
        path, "", nothing ? "is empty but for blank and comment lines" : "no rows of numbers found",
        "give a table with a header and a line for each row; --delimiter and --decimal "
        "say how it is written");
  }
  if (best.fields > kMostColumns) {
    throw LogError(path, "line " + std::to_string(best.first_row + 1),
                   "has " + std::to_string(best.fields) + " fields, allowed are up to " +
                       std::to_string(kMostColumns),
                   "give a table with a column for each signal and a line for each row");
  }
  first_line_ = best.first_row + 1;
  split_at_decimals_ = mayBeSplitAtDecimals(head, best.first_row, dialect_.delimiter);

  // The header is the line before the numbers, perhaps with a line of units after it, or the last
  // comment.
  std::vector<std::string> units;
  for (std::size_t k = best.first_row; k-- > 0;) {
    if (isEmpty(head[k])) continue;
    const std::size_t text = isComment(head[k]) ? head[k].find_first_not_of("#% \t") : 0;
    if (text == std::string::npos) continue;
    std::vector<std::string> texts =
        textsOf(std::string_view(head[k]).substr(text), dialect_.delimiter);
    if (split_at_decimals_ && 1 < texts.size() && texts.size() < best.fields) {
      throw LogError(path, "line " + std::to_string(k + 1),
                     std::to_string(texts.size()) + " names over rows of " +
                         std::to_string(best.fields) +
                         " fields: commas are both delimiter and decimal sign",
                     kMendOfCommas);
    }
    if (texts.size() != best.fields) break;
    const bool all_units = std::all_of(texts.begin(), texts.end(), [](const std::string& field) {
      const std::string plain = boost::algorithm::trim_copy_if(field, boost::is_any_of("[]() "));
      return plain.empty() || isUnit(plain);
    });
    if (all_units && units.empty() && k > 0) {
      units = std::move(texts);
      continue;
    }
    names_ = std::move(texts);
    break;
  }
  if (names_.empty()) names_ = std::exchange(units, {});
  named_ = !names_.empty();
  for (std::size_t k = 0; k < best.fields && named_ && !units.empty(); ++k) {
    const std::string plain = boost::algorithm::trim_copy_if(units[k], boost::is_any_of("[]() "));
    if (!plain.empty()) names_[k] += " [" + plain + "]";
  }
  for (std::size_t k = names_.size(); k < best.fields; ++k) names_.push_back(std::to_string(k + 1));

  std::string_view line;
  while (lines_.number() + 1 < first_line_ && lines_.next(line)) {
  }
}

bool CsvSource::next(std::vector<double>& values) {
  std::string_view line;
  do {
    if (!lines_.next(line)) return false;
  } while (isEmpty(line) || isComment(line));
  splitFields(line, dialect_.delimiter, fields_);
  if (fields_.size() != names_.size()) failRagged(fields_.size());
  values.resize(columns_.size());
  for (std::size_t k = 0; k < columns_.size(); ++k) {
    const std::string_view field = fields_[columns_[k]];
    const std::optional<double> value = parseNumber(field, dialect_.decimal);
    if (!value) failNumber(columns_[k], field);
    values[k] = *value;
  }
  return true;
}

std::string CsvSource::place() const { return "line " + std::to_string(lines_.number()); }

std::string CsvSource::format() const {
  return "text, delimiter " + nameOf(dialect_.delimiter) + ", decimal " +
         (dialect_.decimal == ',' ? "comma" : "point") +
         (named_ ? "" : ", without a header: columns by number");
}

void CsvSource::failRagged(std::size_t fields) const {
  std::string mend = "mend the line, or leave such rows out with --partial";
  if (lines_.cut()) {
    mend = "the file ends in the middle of it: take what is there with --partial";
  } else if (split_at_decimals_ || (dialect_.delimiter == ',' && fields > names_.size())) {
    mend = std::string("if commas are both delimiter and decimal sign, ") + kMendOfCommas +
           "; otherwise " + mend;
  }
  throw RowError(RowFault::kRagged, lines_.path(), place(),
                 std::to_string(fields) + " fields where there are " +
                     std::to_string(names_.size()) + " columns",
                 mend);
}

void CsvSource::failNumber(std::size_t column, std::string_view field) const {
  const bool comma = dialect_.decimal == '.' && parseNumber(field, ',').has_value();
  const bool point = dialect_.decimal == ',' && parseNumber(field, '.').has_value();
  throw RowError(RowFault::kNotANumber, lines_.path(), place() + ", column " + names_[column],
                 field.empty() ? "is empty" : "'" + std::string(field) + "' is no number",
                 comma   ? "if that is a decimal comma say --decimal comma"
                 : point ? "if that is a decimal point say --decimal point"
                         : "mend it, or leave such rows out with --partial");
}

}  // namespace cvg
