//! The words of qualities and principles, which the crate `devices` declares without JSON.

use crate::words::Words;
use profivac_devices::Principle;
use profivac_devices::reading::Quality;

impl Words for Quality {
    const ALL: &'static [Self] = &Self::ALL;

    fn word(self) -> &'static str {
        self.word()
    }
}

impl Words for Principle {
    const ALL: &'static [Self] =
        &[Self::Pirani, Self::HotCathode, Self::ColdCathode, Self::Diaphragm, Self::Atmosphere];

    fn word(self) -> &'static str {
        match self {
            Self::Pirani => "pirani",
            Self::HotCathode => "hot-cathode",
            Self::ColdCathode => "cold-cathode",
            Self::Diaphragm => "diaphragm",
            Self::Atmosphere => "atmosphere",
        }
    }
}

/// The schemas: `#[schema(value_type = quality::schema::Quality)]`.
#[cfg(feature = "openapi")]
pub mod schema {
    use crate::words::Words;
    use std::borrow::Cow;
    use utoipa::openapi::RefOr;
    use utoipa::openapi::schema::{ObjectBuilder, Schema, Type};
    use utoipa::{PartialSchema, ToSchema};

    macro_rules! schemas {
        ($($name:ident $text:literal;)+) => {$(
            #[doc = $text]
            pub struct $name;

            impl PartialSchema for $name {
                fn schema() -> RefOr<Schema> {
                    let words = <super::$name as Words>::ALL.iter().map(|value| Words::word(*value));
                    let words = words.collect::<Vec<_>>();
                    ObjectBuilder::new().schema_type(Type::String).description(Some($text)).enum_values(Some(words)).into()
                }
            }

            impl ToSchema for $name {
                fn name() -> Cow<'static, str> {
                    stringify!($name).into()
                }
            }
        )+};
    }

    schemas! {
        Quality "The state of a reading: whether it is a pressure, and if not, why.";
        Principle "The principle by which a measuring part senses pressure.";
    }
}
