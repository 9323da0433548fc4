// SPDX-License-Identifier: Apache-2.0
#include "hdStream/film/lightPathParser.h"

#include "hdStream/base/error.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <memory>
#include <optional>

namespace hds {

namespace {

constexpr const char* kTypes = "CRTVLOB";
constexpr const char* kScatteringLetters = "DGSs";
constexpr std::uint32_t kMaxRepeats = 99;
constexpr std::size_t kMaxNodes = 20000; ///< repeats of repeats multiply
constexpr std::uint32_t kMaxNesting = 100;

bool IsOneOf(const char* letters, char letter) {
    return letter != '\0' && std::strchr(letters, letter) != nullptr;
}

bool HasType(const LightEvent& event, char type) {
    return type == 'B' ? event.isDome : event.type == type;
}

using Predicate = std::function<bool(const LightEvent&)>;

Predicate Any() {
    return [](const LightEvent&) { return true; };
}

Predicate Not(Predicate inner) {
    return [inner = std::move(inner)](const LightEvent& event) { return !inner(event); };
}

Predicate Both(Predicate a, Predicate b) {
    return [a = std::move(a), b = std::move(b)](const LightEvent& e) { return a(e) && b(e); };
}

/// However many they are: one that held the other would be as deep as they are many.
Predicate AnyOf(std::vector<Predicate> inner) {
    return [inner = std::move(inner)](const LightEvent& event) {
        return std::any_of(inner.begin(), inner.end(),
                           [&](const Predicate& matches) { return matches(event); });
    };
}

Predicate OfType(char type) {
    return [type](const LightEvent& event) { return HasType(event, type); };
}

Predicate OfScattering(char scattering) {
    return [scattering](const LightEvent& event) { return event.scattering == scattering; };
}

Predicate OfLabel(const std::string& label) {
    return [label](const LightEvent& event) { return event.type == 'L' && event.label == label; };
}

/// What an expression means: a tree, so that repeats can be written out.
struct Tree {
    enum Kind { Event, Sequence, Choice, Repeat };
    Kind kind = Event;
    Predicate matches;       ///< of Event
    std::vector<Tree> parts; ///< of the others
    std::uint32_t least = 0; ///< of Repeat
    std::optional<std::uint32_t> most;
};

/// Recursive descent over the text.
class Parser {
public:
    explicit Parser(const std::string& text) : _text(text) {}

    Tree Parse() {
        Tree tree = ParseChoice();
        if (!IsAtEnd()) {
            Fail(Peek() == ')' ? "')' without '('"
                               : "'" + std::string(1, Peek()) + "' is unexpected");
        }
        return tree;
    }

    const std::vector<std::string>& Labels() const { return _labels; }

private:
    [[noreturn]] void Fail(const std::string& what) const {
        throw Error("light path expression '" + _text + "', column " + std::to_string(_at + 1) +
                        ": " + what,
                    ErrorKind::Usage);
    }

    bool IsAtEnd() {
        while (_at < _text.size() && (_text[_at] == ' ' || _text[_at] == '\t')) {
            ++_at;
        }
        return _at == _text.size();
    }

    /// The next letter; 0 at the end.
    char Peek() { return IsAtEnd() ? '\0' : _text[_at]; }

    bool Accept(char letter) {
        if (Peek() != letter) {
            return false;
        }
        ++_at;
        return true;
    }

    void Expect(char letter, const std::string& of) {
        if (!Accept(letter)) {
            Fail("'" + std::string(1, letter) + "' of " + of + " is missing");
        }
    }

    Tree ParseChoice() {
        if (++_nesting > kMaxNesting) {
            Fail("too many parentheses inside each other");
        }
        Tree tree{Tree::Choice, {}, {}, 0, {}};
        do {
            tree.parts.push_back(ParseSequence());
        } while (Accept('|'));
        --_nesting;
        return tree;
    }

    Tree ParseSequence() {
        Tree tree{Tree::Sequence, {}, {}, 0, {}};
        while (Peek() != '\0' && Peek() != '|' && Peek() != ')') {
            tree.parts.push_back(ParseRepeat());
        }
        if (tree.parts.empty()) {
            Fail("there is no event");
        }
        return tree;
    }

    Tree ParseRepeat() {
        Tree tree = ParseAtom();
        for (std::uint32_t numRepeats = 0;; ++numRepeats) {
            std::uint32_t least = 0;
            std::optional<std::uint32_t> most;
            if (Accept('?')) {
                most = 1;
            } else if (Accept('+')) {
                least = 1;
            } else if (Peek() == '{') {
                ParseCounts(&least, &most);
            } else if (!Accept('*')) {
                return tree;
            }
            if (numRepeats >= kMaxNesting) {
                Fail("too many repeats of one event");
            }
            Tree repeat{Tree::Repeat, {}, {}, least, most};
            repeat.parts.push_back(std::move(tree));
            tree = std::move(repeat);
        }
    }

    /// {n}, {n,}, {,m} or {n,m}
    void ParseCounts(std::uint32_t* least, std::optional<std::uint32_t>* most) {
        Expect('{', "a count");
        const std::optional<std::uint32_t> first = ParseNumber();
        *least = first.value_or(0);
        *most = first;
        if (Accept(',')) {
            *most = ParseNumber();
            if (!first && !*most) {
                Fail("a count is missing");
            }
        } else if (!first) {
            Fail("a count is missing");
        }
        if (*most && **most < *least) {
            Fail("the second count is below the first");
        }
        Expect('}', "a count");
    }

    std::optional<std::uint32_t> ParseNumber() {
        std::optional<std::uint32_t> number;
        while (Peek() >= '0' && Peek() <= '9') {
            number = 10 * number.value_or(0) + static_cast<std::uint32_t>(_text[_at] - '0');
            if (*number > kMaxRepeats) {
                Fail("counts go up to " + std::to_string(kMaxRepeats));
            }
            ++_at;
        }
        return number;
    }

    Tree ParseAtom() {
        if (Accept('(')) {
            Tree inner = ParseChoice();
            Expect(')', "a group");
            return inner;
        }
        Predicate matches = Accept('[') ? ParseSet([this] { return ParseEvent(); }) : ParseEvent();
        return {Tree::Event, std::move(matches), {}, 0, {}};
    }

    /// The rest of [...] or [^...].
    Predicate ParseSet(const std::function<Predicate()>& parseItem) {
        const bool isComplement = Accept('^');
        if (Peek() == ']') {
            Fail("the set is empty");
        }
        std::vector<Predicate> items;
        do {
            items.push_back(parseItem());
        } while (Peek() != ']' && Peek() != '\0');
        Expect(']', "a set");
        Predicate matches = AnyOf(std::move(items));
        return isComplement ? Not(std::move(matches)) : matches;
    }

    /// One event: a letter, with a label or without, a label alone, or <...>.
    Predicate ParseEvent() {
        if (Accept('<')) {
            Predicate matches = ParseLetterOrSet(kTypes, "type of event (C R T V L O B)");
            if (Peek() != '>' && Peek() != '\'') {
                matches = Both(std::move(matches),
                               ParseLetterOrSet(kScatteringLetters, "scattering (D G S s)"));
            }
            if (Peek() == '\'' || Peek() == '[') {
                matches =
                    Both(std::move(matches),
                         Accept('[') ? ParseSet([this] { return ParseLabel(); }) : ParseLabel());
            }
            Expect('>', "an event");
            return matches;
        }
        if (Peek() == '\'') {
            return ParseLabel();
        }
        Predicate matches = ParseLetter(std::string(kTypes) + kScatteringLetters, "event");
        return Peek() == '\'' ? Both(std::move(matches), ParseLabel()) : matches;
    }

    Predicate ParseLetterOrSet(const char* letters, const std::string& what) {
        return Accept('[') ? ParseSet([&] { return ParseLetter(letters, what); })
                           : ParseLetter(letters, what);
    }

    Predicate ParseLetter(const std::string& letters, const std::string& what) {
        const char letter = Peek();
        if (letter == '.') {
            ++_at;
            return Any();
        }
        if (letter == '\0') {
            Fail("an " + std::string("event is missing"));
        }
        if (!IsOneOf(letters.c_str(), letter)) {
            Fail("'" + std::string(1, letter) + "' is no " + what);
        }
        ++_at;
        return IsOneOf(kTypes, letter) ? OfType(letter) : OfScattering(letter);
    }

    /// 'group' of lights.
    Predicate ParseLabel() {
        if (Peek() != '\'') {
            Fail("a label in quotes ('key') is missing");
        }
        const std::size_t begin = ++_at;
        const std::size_t end = _text.find('\'', begin);
        if (end == std::string::npos || end == begin) {
            Fail(end == begin ? "the label is empty" : "the label has no second quote");
        }
        _labels.push_back(_text.substr(begin, end - begin));
        _at = end + 1;
        return OfLabel(_labels.back());
    }

    const std::string& _text;
    std::size_t _at = 0;
    std::uint32_t _nesting = 0;
    std::vector<std::string> _labels;
};

/// Thompson's construction.
class Builder {
public:
    Builder(const std::string& text, const std::vector<LightEvent>& events)
        : _text(text), _events(events) {}

    LightPathMachine Build(const Tree& tree) {
        const auto [start, end] = Add(tree);
        _machine.start = start;
        _machine.end = end;
        return std::move(_machine);
    }

private:
    using Span = std::pair<std::uint32_t, std::uint32_t>;

    std::uint32_t NewNode() {
        if (_machine.nodes.size() >= kMaxNodes) {
            throw Error("light path expression '" + _text +
                            "': its counts multiply to too many events",
                        ErrorKind::Usage);
        }
        _machine.nodes.emplace_back();
        return static_cast<std::uint32_t>(_machine.nodes.size() - 1);
    }

    void Join(std::uint32_t from, std::uint32_t to) { _machine.nodes[from].free.push_back(to); }

    Span Add(const Tree& tree) {
        switch (tree.kind) {
        case Tree::Event:
            return AddEvent(tree);
        case Tree::Sequence:
            return AddSequence(tree);
        case Tree::Choice:
            return AddChoice(tree);
        case Tree::Repeat:
            break;
        }
        return AddRepeat(tree);
    }

    Span AddEvent(const Tree& tree) {
        const Span span{NewNode(), NewNode()};
        for (std::size_t i = 0; i < _events.size(); ++i) {
            _machine.nodes[span.first].events[i] = tree.matches(_events[i]);
        }
        _machine.nodes[span.first].next = span.second;
        return span;
    }

    Span AddSequence(const Tree& tree) {
        const std::uint32_t start = NewNode();
        std::uint32_t end = start;
        for (const Tree& part : tree.parts) {
            const Span span = Add(part);
            Join(end, span.first);
            end = span.second;
        }
        return {start, end};
    }

    Span AddChoice(const Tree& tree) {
        const Span span{NewNode(), NewNode()};
        for (const Tree& part : tree.parts) {
            const Span inner = Add(part);
            Join(span.first, inner.first);
            Join(inner.second, span.second);
        }
        return span;
    }

    Span AddRepeat(const Tree& tree) {
        const Span span{NewNode(), NewNode()};
        std::uint32_t at = span.first;
        for (std::uint32_t i = 0; i < tree.most.value_or(tree.least); ++i) {
            if (i >= tree.least) {
                Join(at, span.second);
            }
            const Span inner = Add(tree.parts[0]);
            Join(at, inner.first);
            at = inner.second;
        }
        if (!tree.most) {
            const Span inner = Add(tree.parts[0]);
            Join(at, inner.first);
            Join(inner.second, inner.first);
            Join(inner.second, span.second);
        }
        Join(at, span.second);
        return span;
    }

    const std::string& _text;
    const std::vector<LightEvent>& _events;
    LightPathMachine _machine;
};

} // namespace

std::vector<std::string> LabelsOf(const std::string& expression) {
    Parser parser(expression);
    parser.Parse();
    return parser.Labels();
}

LightPathMachine ParseLightPath(const std::string& expression,
                                const std::vector<LightEvent>& events) {
    return Builder(expression, events).Build(Parser(expression).Parse());
}

} // namespace hds
