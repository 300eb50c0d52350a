//! What money means in a requirement: `[prices]`, and amounts as `"250 EUR"`.
//!
//! The one idea: nothing knows a rate or a day by itself. The requirement gives the rates and their day; a price that they do not
//! cover is not known.

use crate::catalog::{Currency, Date, Offer};
use crate::input::{Key, Problem, Range, Section, key};
use crate::units;

/// A price that is more years than this from the day of the rates is not known.
pub const MOST_YEARS: u16 = 2;

/// In what currency a requirement counts.
#[derive(Debug, Clone, PartialEq)]
pub struct Prices {
    /// The currency.
    pub currency: Currency,
    /// What one of another currency is in it.
    pub rates: Vec<(Currency, f64)>,
    /// The day of the rates.
    pub date: Date,
    /// How many of each part are bought at once.
    pub quantity: u32,
}

/// Why a price is not known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoPrice {
    /// Nobody says one.
    Blank,
    /// Its currency has no rate.
    Rate,
    /// It is too far from the day of the rates.
    Date,
    /// It is that of more pieces than are bought.
    Quantity,
}

impl Prices {
    /// An amount of a currency in that of the requirement; `None` where it has no rate.
    pub fn convert(&self, value: f64, currency: Currency) -> Option<f64> {
        if currency == self.currency {
            return Some(value);
        }
        self.rates.iter().find(|(of, _)| *of == currency).map(|(_, rate)| value * rate)
    }

    /// The price of an offer in the currency of the requirement.
    ///
    /// # Errors
    /// Why it is not known.
    pub fn of(&self, offer: &Offer) -> Result<f64, NoPrice> {
        let price = offer.price().ok_or(NoPrice::Blank)?;
        if !price.date.is_within(MOST_YEARS, self.date) {
            return Err(NoPrice::Date);
        }
        if price.quantity > f64::from(self.quantity) {
            return Err(NoPrice::Quantity);
        }
        self.convert(price.value, price.currency).ok_or(NoPrice::Rate)
    }
}

/// What a requirement says of money, for the reader of an amount.
#[derive(Debug)]
pub(super) enum Money {
    /// There is no `[prices]`.
    Absent,
    /// It has mistakes, which are noted.
    Wrong,
    /// It is there.
    Known(Prices),
}

impl Money {
    /// What is known of it.
    pub(super) fn prices(self) -> Option<Prices> {
        match self {
            Money::Known(prices) => Some(prices),
            Money::Absent | Money::Wrong => None,
        }
    }
}

/// Reads `[prices]`.
pub(super) fn read(root: &Section) -> Money {
    let about = "in what currency prices are counted: without it no price is";
    let Some(section) = root.section(key("prices", about)) else {
        return if root.has("prices") { Money::Wrong } else { Money::Absent };
    };
    let before = root.noted();
    let code = section.required_text(key("currency", "that all prices are counted in, as `EUR`"), "\"EUR\"");
    let currency = code.and_then(|code| currency(&section, code.get_ref(), code.span()));
    let about = "what one of each other currency is worth in `currency`, as `{ USD = 0.92 }`; a price in one that is not \
                 here is not known";
    let mut rates = Vec::new();
    for (code, rate) in section.named_numbers(key("rates", about), Range::Positive) {
        let Some(of) = self::currency(&section, code.get_ref(), code.span()) else { continue };
        if Some(of) == currency && rate != 1.0 {
            let message = format!("`rates` of [prices]: one {of} is one {of}");
            let problem = Problem::at(code.span(), message, "the currency of [prices] itself");
            section.note(problem.help("remove it: a rate says what one of another currency is worth in it"));
        }
        rates.push((of, rate));
    }
    let about = "day of the rates, as `2026-11-01`; a price more than two years from it is not known";
    let day = section.required_text(key("date", about), "\"2026-11-01\"");
    let date = day.and_then(|day| match Date::read(day.get_ref()) {
        Ok(date) => Some(date),
        Err(help) => {
            let message = format!("`date` of [prices]: `{}` is no day", day.get_ref());
            section.note(Problem::at(day.span(), message, "expected year-month-day").help(help));
            None
        }
    });
    let about = "how many of each part are bought at once; a price of more pieces (`price_quantity`) is not known";
    let quantity = section.count(key("quantity", about).default("1"));
    section.finish();
    match (currency, date) {
        (Some(currency), Some(date)) if root.noted() == before => {
            Money::Known(Prices { currency, rates, date, quantity: quantity.unwrap_or(1) })
        }
        _ => Money::Wrong,
    }
}

/// The currency of a code; what is wrong is noted.
fn currency(section: &Section, code: &str, span: std::ops::Range<usize>) -> Option<Currency> {
    match Currency::of(code) {
        Ok(currency) => Some(currency),
        Err(help) => {
            section.note(
                Problem::at(span, format!("`{code}` is no currency"), "expected three capital letters").help(help),
            );
            None
        }
    }
}

/// What may be written for an amount.
const AMOUNT: &str = "money, as `\"250 EUR\"`";

/// Reads an amount of money, in the currency of `[prices]`.
pub(super) fn read_amount(section: &Section, key: Key, range: Range, money: &Money) -> Option<f64> {
    let name = key.name();
    let text = section.text(key.value(AMOUNT))?;
    let wrong = |message: String, label: &str, help: String| {
        section.note(Problem::at(text.span(), format!("`{name}`: {message}"), label).help(help));
        None
    };
    let prices = match money {
        Money::Known(prices) => prices,
        Money::Wrong => return None,
        Money::Absent => {
            let help = "say what money is: [prices] with currency = \"EUR\" and date = \"2026-11-01\"";
            return wrong("an amount of money needs [prices]".into(), "the requirement has none", help.into());
        }
    };
    let (number, code) = units::apart(text.get_ref());
    let example = || format!("for example {name} = \"250 {}\"", prices.currency);
    let Ok(value) = units::number_value(number) else {
        return wrong(
            format!("`{}` is no amount of money", text.get_ref()),
            "expected a number and a currency",
            example(),
        );
    };
    if code.is_empty() {
        return wrong("an amount of money needs its currency".into(), "expected a number and a currency", example());
    }
    let currency = match Currency::of(code) {
        Ok(currency) => currency,
        Err(help) => return wrong(format!("`{code}` is no currency"), "expected three capital letters", help),
    };
    if !range.contains(value) {
        return wrong("the amount is out of range".into(), &format!("expected {}", range.expected()), example());
    }
    let Some(amount) = prices.convert(value, currency) else {
        let help = format!(
            "give one in [prices], for example rates = {{ {currency} = 0.9 }}: what one {currency} is in {}",
            prices.currency
        );
        return wrong(format!("[prices] has no rate for {currency}"), "in no currency of [prices]", help);
    };
    Some(amount)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn offer(price: f64, code: &str, day: &str, quantity: Option<f64>) -> Offer {
        let (price_currency, price_date) = (code.to_string(), day.to_string());
        Offer { price: Some(price), price_quantity: quantity, price_currency, price_date, lead_time: None }
    }

    #[test]
    fn a_price_is_known_where_rate_day_and_quantity_are() {
        let of = |code| Currency::of(code).unwrap();
        let date = Date::read("2026-11-01").unwrap();
        let rates = vec![(of("CNY"), 0.125), (of("USD"), 0.9)];
        let prices = Prices { currency: of("EUR"), rates, date, quantity: 10 };
        for (offered, known) in [
            (offer(100.0, "EUR", "2026-11-01", None), Ok(100.0)),
            (offer(800.0, "CNY", "2024-11-01", Some(10.0)), Ok(100.0)),
            (offer(100.0, "USD", "2028-10-31", None), Ok(90.0)),
            (offer(100.0, "GBP", "2026-11-01", None), Err(NoPrice::Rate)),
            (offer(100.0, "EUR", "2024-10-31", None), Err(NoPrice::Date)),
            (offer(100.0, "EUR", "2028-11-02", None), Err(NoPrice::Date)),
            (offer(100.0, "EUR", "2026-11-01", Some(11.0)), Err(NoPrice::Quantity)),
            (Offer::default(), Err(NoPrice::Blank)),
        ] {
            assert_eq!(prices.of(&offered), known, "{offered:?}");
        }
    }
}
