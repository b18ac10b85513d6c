//! What is wrong with a file, and what to do about it.

use std::fmt;

/// A tool that objects to a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tool {
    /// pyprofibus 1.13.
    Pyprofibus,
    /// The crate gsd-parser 0.6.0, which profirust uses.
    GsdParser,
}

impl fmt::Display for Tool {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Tool::Pyprofibus => "pyprofibus 1.13",
            Tool::GsdParser => "gsd-parser 0.6.0",
        })
    }
}

/// How much a problem matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The line is right, but a known tool does not read it, or it is unusual.
    Remark,
    /// The line is wrong; the reader decided as the problem says.
    Fault,
}

/// A problem of a file: its line and what is wrong there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// The line, from 1.
    pub line: usize,
    /// What is wrong.
    pub fault: Fault,
    /// What the line has, for instance the text that is too long.
    pub found: String,
}

impl Problem {
    pub(crate) fn new(line: usize, fault: Fault, found: impl Into<String>) -> Self {
        Self { line, fault, found: found.into() }
    }

    /// How much it matters.
    #[must_use]
    pub fn severity(&self) -> Severity {
        self.fault.row().0
    }

    /// What is wrong, in a few words.
    #[must_use]
    pub fn what(&self) -> &'static str {
        self.fault.row().1
    }

    /// What the reader does with the line, and what the author of the file can do.
    #[must_use]
    pub fn remedy(&self) -> &'static str {
        self.fault.row().2
    }

    /// The tools that are known to object.
    #[must_use]
    pub fn tools(&self) -> &'static [Tool] {
        self.fault.row().3
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: {}", self.line, self.what())?;
        if !self.found.is_empty() {
            write!(f, " ({})", self.found)?;
        }
        write!(f, "; {}", self.remedy())?;
        for (index, tool) in self.tools().iter().enumerate() {
            write!(f, "{}{tool}", if index == 0 { "; not read as meant by " } else { ", " })?;
        }
        Ok(())
    }
}

type Row = (Severity, &'static str, &'static str, &'static [Tool]);

macro_rules! faults {
    ($($name:ident $severity:ident $what:literal, $remedy:literal $(, $tool:ident)*;)*) => {
        /// A kind of problem.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum Fault {
            $(#[doc = concat!($what, ".")] $name,)*
        }

        impl Fault {
            /// Every kind.
            pub const ALL: &[Fault] = &[$(Fault::$name),*];

            fn row(self) -> Row {
                match self {
                    $(Fault::$name => (Severity::$severity, $what, $remedy, &[$(Tool::$tool),*]),)*
                }
            }
        }
    };
}

impl Fault {
    /// What a wrong value means for a list of octets: those before it stay.
    pub(crate) fn in_list(self) -> Fault {
        match self {
            Fault::RepeatedComma => self,
            _ => Fault::BadOctet,
        }
    }
}

faults! {
    Utf16 Remark "file is UTF-16", "it is read; save it as ASCII, or in cp1252 if it has letters beyond ASCII", Pyprofibus, GsdParser;
    DamagedUtf16 Fault "file begins as UTF-16 and is damaged", "open it in an editor and save it as ASCII", Pyprofibus, GsdParser;
    MarkBeforeHeader Remark "byte order mark before #Profibus_DP", "save the file without it, or write a line of comment above", Pyprofibus, GsdParser;
    NoHeader Fault "no line #Profibus_DP", "the file is read anyway; write #Profibus_DP above the first keyword", Pyprofibus, GsdParser;
    TextBehindHeader Remark "text behind #Profibus_DP", "move the comment to the next line", Pyprofibus, GsdParser;
    HeaderCapitals Remark "#Profibus_DP in other capitals", "write #Profibus_DP", Pyprofibus;
    TextBeforeHeader Remark "lines before the line #Profibus_DP", "they are ignored; move #Profibus_DP to the top if they describe the slave";
    SectionEnd Remark "line with # ends the section of PROFIBUS DP", "this line and all behind it are ignored; remove it if they describe the slave";
    Capitals Remark "keyword in other capitals", "write the keyword as the specification does", Pyprofibus;
    CapitalX Remark "0X in front of a hexadecimal number", "write 0x", Pyprofibus, GsdParser;
    InvertedBit Remark "Unit_Diag_!Bit", "the line is right; remove it for the tool", GsdParser;
    BlankInKeyword Fault "blank in a keyword", "it is read with _ in place of the blank; write _", GsdParser;
    CommentBehindContinuation Remark "comment behind \\", "the list goes on in the next line; move the comment to a line of its own";
    BlankBehindContinuation Remark "blank behind \\", "the list goes on in the next line; remove the blank", Pyprofibus;
    ContinuationOfNothing Fault "\\ at the end of a statement", "remove the \\", Pyprofibus, GsdParser;
    ListWithoutContinuation Fault "list goes on in this line without \\ in the line above", "it is read as one list; write \\ behind the comma above", Pyprofibus, GsdParser;
    StrayBackslash Fault "\\ within a line", "it is ignored; remove it", Pyprofibus, GsdParser;
    OpenString Fault "closing quotation mark missing", "the text ends with the line; write the quotation mark", GsdParser;
    StringWithoutContinuation Fault "text goes on in the next line without \\", "it is read as one text; write \\ at the end of the line";
    TextBehindString Fault "words behind a text in quotation marks", "they are ignored; remove them or write a semicolon before them", GsdParser;
    QuoteInText Remark "quotation mark within a text", "it belongs to the text; write an apostrophe", Pyprofibus, GsdParser;
    UnknownKeyword Remark "keyword is not known", "the line is kept but not interpreted; check its spelling";
    NoKeyword Fault "line without a keyword", "the line is kept but not interpreted; remove it or make it a comment", GsdParser;
    BadValue Fault "value cannot be read", "the line is kept but not interpreted; correct the value", GsdParser;
    OutOfRange Fault "value out of range", "the line is kept but not interpreted; correct the value";
    TooMany Fault "more modules, parameters or values than are read", "what is beyond the limit is not interpreted; remove it";
    BadOctet Fault "value in a list that is no octet", "the octets before it count, the rest of the list is ignored; correct the list";
    RepeatedComma Fault "comma without a value before it", "the comma is ignored; remove it or write the missing value";
    Repeated Remark "keyword occurs twice", "the last line counts; remove one";
    MisplacedKeyword Fault "keyword outside its block", "the line is kept but not interpreted; move it into the block";
    MissingEnd Fault "end of the block above is missing", "the block ends here; write its End line", Pyprofibus, GsdParser;
    StrayEnd Fault "end of a block that is not open", "remove the line", GsdParser;
    DefinitionTwice Fault "number is defined twice", "the last definition counts; give each a number of its own";
    MissingDefault Fault "default value missing", "the first allowed value is the default; write the default in front of the range";
    BadBits Fault "bits beyond the octet, or in falling order", "write bits from 0 to 7, the lower one first";
    UnknownText Fault "Prm_Text_Ref to texts that the file lacks", "the parameter has no texts; define the PrmText", GsdParser;
    UnknownParameter Fault "reference to an ExtUserPrmData that the file lacks", "the reference is ignored; define the ExtUserPrmData", GsdParser;
    DefaultOutOfRange Fault "default value outside the allowed values", "the default is sent all the same, as far as its bits fit; correct it";
    BeyondLength Fault "parameter reaches beyond the length that the file gives", "a slave may refuse such parameters; correct the length or the offset";
    PrmLength Fault "User_Prm_Data has another length than User_Prm_Data_Len says", "User_Prm_Data_Len counts; correct one of them";
    BothPrm Remark "User_Prm_Data differs from Ext_User_Prm_Data", "the Ext_User_Prm_Data are sent; make both equal";
    NoIdent Fault "Ident_Number missing", "write the Ident_Number that the slave has";
    NoModules Remark "file has no module", "such a slave has no configuration; write the modules";
    BadIdentifiers Fault "configuration octets are no list of identifiers", "they are sent as they are; correct them";
    ModuleNumberTwice Fault "module number occurs twice", "the first module has the number; give each a number of its own";
    ModuleNameTwice Remark "module name occurs twice", "choose such modules by their numbers";
    ModuleName Remark "module name with another sign than ASCII letters, digits and common signs", "the line is right; write another name for the tool, which leaves such modules out", Pyprofibus;
    ModuleBlank Remark "no blank between the name and the octets of a module", "write a blank", Pyprofibus;
    UnknownModule Fault "slot allows a module number that the file lacks", "the number is ignored; correct the list";
    SlotDefault Fault "default module of the slot is not among its allowed modules", "it is allowed too; add it to the list";
}
